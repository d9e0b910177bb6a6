// What commands share of their arguments, with the defaults.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cache/policy.h"
#include "io/open_volume.h"
#include "src/gl/context.h"

namespace sluice {

// Which volume, and how to read it where the file does not say.
struct VolumeArguments {
  std::vector<std::string> inputs;
  OpenOptions open;
  int64_t time = 0;
};

// How it looks.
struct LookArguments {
  std::optional<double> threshold;
  std::string transfer_file;
  std::string map;
  std::optional<double> opacity;
  bool shade = false;
  bool modulate = false;       // the opacity by the gradient's magnitude
  double full_gradient = 0.1;  // where that is 1: a share of the value range a voxel length
  std::array<float, 3> background{0, 0, 0};
  bool has_background = false;
};

// What it may take.
struct ResourceArguments {
  uint64_t memory_bytes = 0;  // 0: half of what the machine has
  int threads = 0;            // 0: one a core
  GlChoice gl = GlChoice::kAuto;
  std::optional<Vec3i> page_vox;
  std::optional<int64_t> pages;
  std::optional<int64_t> block;
  PolicyKind policy = PolicyKind::kLru;
  uint64_t seed = 1;
};

}  // namespace sluice
