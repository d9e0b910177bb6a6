#include "src/index/series_pass.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/visibility/plenoptic/fusion.h"
#include "src/volume/ranges/block_ranges.h"
#include "src/volume/voxels/device_reader.h"

namespace sluice {
namespace {

constexpr int64_t kMostRun = 32;  // blocks

struct Run {
  int64_t first = 0, count = 1;  // block ids
};

// A block during the pass: its closed spans, and the representative of the open one.
struct Growing {
  BlockOpacity done;
  OpacityBlock representative;
  bool is_empty = true;
  int32_t since = -1;  // -1: none is open
};

struct Clocks {
  std::atomic<int64_t> read{0}, fusion{0}, functions{0};
};
void add(std::atomic<int64_t>& clock, Stopwatch& watch) {
  clock += static_cast<int64_t>(watch.lap() * 1e9);
}

// A run is taken through all steps at once: of each block, the representative and the current step
// are in memory.
class Pass {
 public:
  Pass(VolumeSource& source, const BlockLayout& layout, const std::vector<StepBlocks>& steps,
       const ExtinctionTable& table, const SeriesPassOptions& options)
      : source_(source),
        layout_(layout),
        steps_(steps),
        table_(table),
        options_(options),
        map_(deviceMap(source.layout())),
        type_(map_.type),
        coherent_(steps.size()),
        blocks_(steps.size()) {}

  uint64_t bytesOfBlock() const {
    const int64_t side = layout_.cells() + 1;
    const auto voxels = static_cast<uint64_t>(volume(Vec3i{side, side, side}));
    // The least extinctions are those of cubes, kDetail of which make a part along each axis.
    const auto cubes = static_cast<uint64_t>(
        volume(PartGrid{{side, side, side}, options_.part_cells / kDetail}.count()));
    // Voxels as they are read, and the opacities and cubes of one block and the representative.
    return voxels * (bytesPerVoxel(source_.layout().type) + bytesPerVoxel(type_)) +
           2 * (voxels + cubes) * sizeof(float);
  }

  // Progress in bytes: the voxels of `blocks` blocks at one step.
  uint64_t bytesOfSteps(int64_t blocks) const {
    const int64_t side = layout_.cells();
    return static_cast<uint64_t>(blocks * volume(Vec3i{side, side, side})) *
           bytesPerVoxel(source_.layout().type);
  }

  std::vector<Run> runs(const VolumePass& pass) const {
    // A run of one block is taken even if it exceeds the limit: the pass would not run otherwise.
    const uint64_t a_thread = pass.memory_bytes / static_cast<uint64_t>(pass.pool.threads());
    const int64_t most =
        std::clamp<int64_t>(static_cast<int64_t>(a_thread / bytesOfBlock()), 1, kMostRun);
    std::vector<Run> result;
    for (int64_t row = 0; row < layout_.grid.y * layout_.grid.z; ++row)
      // A run stays within a row, whose voxels lie together.
      for (int64_t x = 0; x < layout_.grid.x; x += most)
        result.push_back({row * layout_.grid.x + x, std::min(most, layout_.grid.x - x)});
    return result;
  }

  std::vector<BlockOpacity> of(const Run& run, const VolumePass& pass) {
    std::vector<Growing> growing(static_cast<size_t>(run.count));
    std::vector<std::byte> voxels;
    OpacityBlock current;
    for (size_t step = 0; step < steps_.size(); ++step) {
      pass.stop.throwIfStopped();
      Stopwatch watch;
      const Box3 box = read(run, static_cast<int64_t>(step), voxels);
      add(clocks_.read, watch);
      for (int64_t i = 0; i < run.count; ++i)
        addStep(growing[static_cast<size_t>(i)], run.first + i, step, box, voxels, current);
      pass.progress.add(bytesOfSteps(run.count));
    }
    std::vector<BlockOpacity> result;
    for (Growing& each : growing) {
      finishSpan(each);
      result.push_back(std::move(each.done));
    }
    return result;
  }

  Clocks& clocks() { return clocks_; }
  void countInto(SeriesPassReport& report) const {
    for (size_t step = 1; step < steps_.size(); ++step) {
      report.blocks.push_back(blocks_[step]);
      report.coherent.push_back(coherent_[step]);
    }
  }

 private:
  Box3 voxelsOf(int64_t block) const {
    const Box3 cells = layout_.ownedCells(layout_.indexOf(block));
    return {cells.lo, cells.hi + Vec3i{1, 1, 1}};
  }

  // The voxels of those blocks of the run that are not of one value, and of the blocks between
  // them; empty if there are none.
  // The blocks in between are read along: one read of a box is cheaper than several.
  Box3 read(const Run& run, int64_t step, std::vector<std::byte>& voxels) {
    const StepBlocks& known = steps_[static_cast<size_t>(step)];
    Box3 box{};
    for (int64_t block = run.first; block < run.first + run.count; ++block)
      if (!known.isEmpty(block) && !known.isUniform(block)) box = unite(box, voxelsOf(block));
    if (box.empty()) return box;
    voxels.resize(static_cast<size_t>(box.count()) * bytesPerVoxel(type_));
    DeviceReader(source_).read(step, {box, voxels});
    return box;
  }

  void fill(int64_t block, int64_t step, const Box3& box, const std::vector<std::byte>& voxels,
            OpacityBlock& out) const {
    const StepBlocks& known = steps_[static_cast<size_t>(step)];
    const Box3 own = voxelsOf(block);
    const PartGrid grid{own.size() - Vec3i{1, 1, 1}, options_.part_cells / kDetail};
    // A block of one value needs no voxel.
    if (known.isUniform(block)) {
      fillUniform(known.valuesOf(block).lo, grid, table_, out);
      return;
    }
    const Vec3i from = own.lo - box.lo, size = box.size();
    visitDeviceType(type_, [&](auto tag) {
      const auto* first = reinterpret_cast<const decltype(tag)*>(voxels.data()) +
                          (from.z * size.y + from.y) * size.x + from.x;
      const auto range = rangeOf(first, own.size(), size.x, size.x * size.y);
      expectSameValues({.time = step, .block = block},
                       {static_cast<double>(range.lo), static_cast<double>(range.hi)},
                       known.valuesOf(block),
                       {source_.layout().calledBy(), map_, known.indexFile()});
      fillOpacityBlock(first, size.x, size.x * size.y, grid, table_, out);
    });
  }

  void addStep(Growing& growing, int64_t block, size_t step, const Box3& box,
               const std::vector<std::byte>& voxels, OpacityBlock& current) {
    Stopwatch watch;
    const bool is_empty = steps_[step].isEmpty(block);
    // Before the first step a block counts as empty.
    const bool was_empty = step == 0 || steps_[step - 1].isEmpty(block);
    const bool counts = step > 0 && !(is_empty && was_empty);
    if (counts) ++blocks_[step];
    // A block that stays empty is coherent, whatever the threshold of difference.
    if (growing.since >= 0 && is_empty && growing.is_empty) {
      if (counts) ++coherent_[step];
      return;
    }
    if (!is_empty) fill(block, static_cast<int64_t>(step), box, voxels, current);
    const bool joins = growing.since >= 0 && options_.difference > 0 &&
                       differenceOf(growing, is_empty, current) < options_.difference;
    if (joins) {
      if (counts) ++coherent_[step];
      if (is_empty) {
        // The representative has the least opacity of its steps, so that it hides no more than any
        // of them.
        growing.is_empty = true;  // the least of both
      } else if (!growing.is_empty) {
        fuse(growing.representative, current);
      }
      add(clocks_.fusion, watch);
      return;
    }
    add(clocks_.fusion, watch);
    finishSpan(growing);
    // The lap leaves out the functions, which finishSpan() has counted itself.
    watch.lap();
    growing.since = static_cast<int32_t>(step);
    growing.is_empty = is_empty;
    // Buffers change places, so that both keep their memory.
    if (!is_empty) std::swap(growing.representative, current);
    add(clocks_.fusion, watch);
  }

  static double differenceOf(const Growing& growing, bool is_empty, const OpacityBlock& current) {
    const std::vector<float>& before = growing.representative.opacity;
    if (!growing.is_empty && !is_empty) return blockDifference(before, current.opacity);
    const std::vector<float>& other = is_empty ? before : current.opacity;
    // An empty block has no opacity anywhere.
    return blockDifference(other, std::vector<float>(other.size(), 0));
  }

  void finishSpan(Growing& growing) {
    if (growing.since < 0) return;
    Stopwatch watch;
    BlockOpacity& done = growing.done;
    done.spans.push_back({growing.since, static_cast<int32_t>(done.functions.size())});
    done.functions.push_back(growing.is_empty
                                 ? OpacityFunction{}
                                 : opacityFunction(growing.representative.parts,
                                                   options_.directions, options_.detail_bits));
    add(clocks_.functions, watch);
  }

  VolumeSource& source_;
  const BlockLayout& layout_;
  const std::vector<StepBlocks>& steps_;
  const ExtinctionTable& table_;
  const SeriesPassOptions& options_;
  const ValueMap map_;
  const DeviceType type_;
  Clocks clocks_;
  std::vector<std::atomic<int64_t>> coherent_, blocks_;
};

}  // namespace

StepBlocks::StepBlocks(const SliceRanges& ranges, const ExtinctionTable& table)
    : kinds_(static_cast<size_t>(ranges.layout.blockCount())),
      lows_(kinds_.size()),
      highs_(kinds_.size()),
      index_file_(ranges.index_file) {
  const auto set = [&](size_t block, double lo, double hi) {
    // A block of one value that shows counts as uniform: its function follows without a voxel.
    kinds_[block] = !table.shown().anyIn(lo, hi) ? Kind::kEmpty
                    : lo == hi                   ? Kind::kUniform
                                                 : Kind::kMixed;
    lows_[block] = static_cast<float>(lo);
    highs_[block] = static_cast<float>(hi);
  };
  for (size_t i = 0; i < kinds_.size(); ++i) set(i, ranges.background, ranges.background);
  visitDeviceType(ranges.map.type, [&](auto tag) {
    const auto totals = ranges.totalsAs<decltype(tag)>();
    for (size_t i = 0; i < totals.size(); ++i)
      set(static_cast<size_t>(ranges.blocks[i]), static_cast<double>(totals[i].lo),
          static_cast<double>(totals[i].hi));
  });
}

int64_t StepBlocks::nonEmpty() const {
  return std::count_if(kinds_.begin(), kinds_.end(),
                       [](Kind kind) { return kind != Kind::kEmpty; });
}

double SeriesPassReport::coherentShare() const {
  const int64_t all = std::accumulate(blocks.begin(), blocks.end(), int64_t{0});
  const int64_t stay = std::accumulate(coherent.begin(), coherent.end(), int64_t{0});
  return all == 0 ? 1 : static_cast<double>(stay) / static_cast<double>(all);
}

SeriesOpacity makeSeriesOpacity(VolumeSource& source, const BlockLayout& layout,
                                const std::vector<StepBlocks>& steps, const ExtinctionTable& table,
                                const SeriesPassOptions& options, const VolumePass& pass,
                                SeriesPassReport* report) {
  SLUICE_CHECK_EQ(static_cast<int64_t>(steps.size()), source.layout().time_steps);
  SLUICE_CHECK(options.part_cells > 0 && options.part_cells % kDetail == 0);
  SeriesOpacity series;
  series.dims = layout.dims;
  series.grid = layout.grid;
  series.block_cells = layout.cells();
  series.part_cells = options.part_cells;
  series.steps = static_cast<int64_t>(steps.size());
  series.directions = options.directions;
  Pass work(source, layout, steps, table, options);
  const std::vector<Run> runs = work.runs(pass);
  std::vector<BlockOpacity> blocks(static_cast<size_t>(layout.blockCount()));
  pass.progress.expect(work.bytesOfSteps(layout.blockCount()) * steps.size());
  pass.pool.parallelFor(static_cast<int64_t>(runs.size()), [&](int64_t i) {
    const Run& run = runs[static_cast<size_t>(i)];
    std::vector<BlockOpacity> made = work.of(run, pass);
    std::move(made.begin(), made.end(), blocks.begin() + static_cast<ptrdiff_t>(run.first));
  });
  Stopwatch watch;
  gather(series, std::move(blocks));
  if (report == nullptr) return series;
  // The clocks add up over the threads, and the report tells the time that passed.
  const double a_second = 1e-9 / pass.pool.threads();
  report->read_seconds = static_cast<double>(work.clocks().read) * a_second;
  report->fusion_seconds = static_cast<double>(work.clocks().fusion) * a_second;
  report->functions_seconds = static_cast<double>(work.clocks().functions) * a_second;
  report->tree_seconds = watch.lap();
  report->worker_bytes =
      static_cast<uint64_t>(std::max<int64_t>(1, runs.front().count)) * work.bytesOfBlock();
  work.countInto(*report);
  return series;
}

}  // namespace sluice
