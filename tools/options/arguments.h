// Arguments that commands share, with the defaults: those passed to the library, and those of the
// program alone.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "src/library/requests.h"

namespace sluice {

// Steps of a series: first, first + stride, ... up to last.
struct TimeRange {
  int64_t first = 0, last = 0, stride = 1;

  int64_t count() const { return (last - first) / stride + 1; }
  int64_t at(int64_t i) const { return first + i * stride; }
};

// Which blocks of a step are left out because others hide them (src/render/blocks/culled_blocks.h):
// none; by the least opacity of a block; by the ratio of opacity to thickness; and the same,
// looking only at what changes from step to step; and the last one only if it is faster than none
// (series.h).
enum class Culling { kNone, kPof, kOpof, kToc, kAuto };

struct CullingArguments {
  Culling culling = Culling::kNone;
  double difference = 0.001;  // limit of the difference between blocks that are fused
  int directions = 4;         // rows of the table of directions over 90 degrees
  int64_t part = 4;           // cells a side of a block's parts, a multiple of 4
  int detail = 2;             // bits of a part's 64 cubes at the most
  std::string basis;          // files of transfer functions with commas between; empty: none
};

struct ResourceArguments : MachineOptions {
  std::string index_dir;  // folder for the indices of all volumes; empty: see
                          // tools/command_line/environment.h
  bool quiet = false;     // no progress, no warnings
};

}  // namespace sluice
