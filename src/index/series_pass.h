// The pass over a series that makes its opacity functions (Gao 2004, sections 4 and 5): block by
// block over all time steps, each fused with the coherent steps before it, a function for each
// span.
//
// A worker holds a run of neighbouring blocks along x twice, however many steps there are: the
// representatives so far and the blocks of one step. A run is one block if memory is short. Blocks
// that the min-max arrays know to be empty or of one value are not read.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/index/stale_check.h"
#include "src/visibility/plenoptic/extinction.h"
#include "src/visibility/plenoptic/series_opacity.h"
#include "src/volume/passes/volume_pass.h"
#include "src/volume/ranges/slice_ranges.h"

namespace sluice {

// The classes of a step's blocks, from its min-max arrays.
class StepBlocks {
 public:
  StepBlocks(const SliceRanges& ranges, const ExtinctionTable& table);

  // No sample in the block shows anything.
  bool isEmpty(int64_t block) const { return kinds_[static_cast<size_t>(block)] == Kind::kEmpty; }
  bool isUniform(int64_t block) const {
    return kinds_[static_cast<size_t>(block)] == Kind::kUniform;
  }
  // The range of its device values; both ends are equal if it is uniform.
  BlockValues valuesOf(int64_t block) const {
    const auto b = static_cast<size_t>(block);
    return {lows_[b], highs_[b]};
  }
  // How many blocks are not empty.
  int64_t nonEmpty() const;
  const std::filesystem::path& indexFile() const { return index_file_; }

 private:
  enum class Kind : uint8_t { kEmpty, kUniform, kMixed };
  std::vector<Kind> kinds_;
  std::vector<float> lows_, highs_;  // the least and the greatest value of each block
  std::filesystem::path index_file_;
};

// More makes the pass no faster.
inline constexpr uint64_t kMostSeriesBytes = uint64_t{256} << 20;

struct SeriesPassOptions {
  double difference = 0.001;          // blocks of less (equation 2) are fused; 0: none are
  int64_t part_cells = 4;             // a side; a multiple of kDetail
  int detail_bits = kMostDetailBits;  // see part_detail.h
  DirectionGrid directions = {};
};

struct SeriesPassReport {
  // Mean over the threads.
  double read_seconds = 0, functions_seconds = 0, fusion_seconds = 0;
  double tree_seconds = 0;
  uint64_t worker_bytes = 0;  // the most that one worker held
  // For each step but the first, the blocks that are not empty there or in the step before, and the
  // number of those that stay in their span.
  std::vector<int64_t> blocks, coherent;

  // The share of coherent blocks in `blocks`, over all steps, 0 to 1; 1 if there are none.
  double coherentShare() const;
};

// `steps`: of all time steps of the source, in the layout's blocks. Throws Error from the source,
// which names the file, and if a block that is read has other values than its step says
// (stale_check.h); Interrupted.
SeriesOpacity makeSeriesOpacity(VolumeSource& source, const BlockLayout& layout,
                                const std::vector<StepBlocks>& steps, const ExtinctionTable& table,
                                const SeriesPassOptions& options, const VolumePass& pass,
                                SeriesPassReport* report = nullptr);

}  // namespace sluice
