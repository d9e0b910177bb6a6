// sluice bench cut: the time to plan a picture of a volume that is too large for any disk at hand.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/classify/transfer/transfer_makers.h"
#include "src/render/session/planner.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"

namespace sluice {
namespace {

using nlohmann::json;

struct CutBench {
  Vec3i dims{16821, 7494, 2070};
  FrameOptions frame;
  int threads = 0;  // 0: one a core
  int frames = 9;   // plans measured for each kind
};

constexpr int64_t kBlockSize = 64;
constexpr int64_t kCoarsestVoxels = 256;  // of the coarsest level along its longest axis
constexpr double kShells = 6, kNoise = 6, kOpacity = 0.5, kThreshold = 60, kPlannedStep = 3;
constexpr double kCloseUp = 16;  // zoom of views from close by

// A volume of which nothing is ever read.
class PlannedSource : public VolumeSource {
 public:
  explicit PlannedSource(Vec3i dims) {
    layout_.dims = dims;
    layout_.name = "planned";
  }
  const VolumeLayout& layout() const override { return layout_; }
  void readRegion(int64_t /*time*/, const Box3& /*box*/, std::span<std::byte> /*out*/) override {
    fail("{}: has no voxels", layout_.name);
  }
  std::string identity() const override { return layout_.name; }
  uint64_t storedBytesRead() const override { return 0; }

 private:
  VolumeLayout layout_;
};

// Values follow from the distance to the middle, which is 1 where the ellipsoid ends: shells by
// turns dense and thin, with noise.
class Shells {
 public:
  explicit Shells(Vec3i dims) : middle_((toDouble(dims) - Vec3d{1, 1, 1}) * 0.5) {}

  // The least and the greatest value of these voxels.
  PlaneRange<uint8_t> rangeIn(const Box3& voxels) const {
    double near = 0, far = 0;
    for (int a = 0; a < 3; ++a) {
      const double lo = (static_cast<double>(voxels.lo[a]) - middle_[a]) / middle_[a];
      const double hi = (static_cast<double>(voxels.hi[a] - 1) - middle_[a]) / middle_[a];
      const double nearest = lo > 0 ? lo : hi < 0 ? hi : 0;
      const double farthest = std::max(std::abs(lo), std::abs(hi));
      near += nearest * nearest;
      far += farthest * farthest;
    }
    return rangeBetween(std::sqrt(near), std::sqrt(far));
  }

 private:
  static PlaneRange<uint8_t> rangeBetween(double near, double far) {
    if (near >= 1) return {0, static_cast<uint8_t>(kNoise)};
    // Turning points of the wave lie at whole numbers.
    const double from = near * kShells, to = std::min(far, 1.0) * kShells;
    double lo = std::min(at(from), at(to)), hi = std::max(at(from), at(to));
    // A wave of period 2 reaches all of its values within two turns.
    for (double turn = std::ceil(from); turn <= to && turn <= from + 2; ++turn) {
      lo = std::min(lo, at(turn));
      hi = std::max(hi, at(turn));
    }
    // Noise alone lies outside of the ellipsoid.
    if (far > 1) lo = 0;
    return {static_cast<uint8_t>(std::max(0.0, lo - kNoise)), static_cast<uint8_t>(hi + kNoise)};
  }
  static double at(double shell) { return 120 + 100 * std::cos(std::numbers::pi * shell); }

  const Vec3d middle_;  // half of the volume, too
};

std::shared_ptr<const SliceRanges> rangesOf(const BlockLayout& layout, WorkerPool& pool) {
  const Shells shells(layout.dims);
  SliceRanges ranges;
  ranges.layout = layout;
  ranges.device_range = {0, 255};
  ranges.counts.entries = {{0, 255, 1}};
  const auto blocks = static_cast<size_t>(layout.blockCount());
  const auto planes = static_cast<size_t>(layout.planes());
  std::vector<PlaneRange<uint8_t>> totals(blocks), elements(blocks * 3 * planes);
  ranges.blocks.resize(blocks);
  pool.parallelFor(layout.grid.z * layout.grid.y, [&](int64_t row) {
    for (int64_t block = row * layout.grid.x; block < (row + 1) * layout.grid.x; ++block) {
      const auto at = static_cast<size_t>(block);
      const Box3 owned = layout.ownedVoxels(layout.indexOf(block));
      ranges.blocks[at] = block;
      totals[at] = shells.rangeIn(owned);
      for (int a = 0; a < 3; ++a)
        for (int64_t plane = 0; plane < owned.size()[a]; ++plane) {
          Box3 voxels = owned;
          voxels.lo[a] = owned.lo[a] + plane;
          voxels.hi[a] = voxels.lo[a] + 1;
          elements[(at * 3 + static_cast<size_t>(a)) * planes + static_cast<size_t>(plane)] =
              shells.rangeIn(voxels);
        }
    }
  });
  const auto bytesOf = [](const std::vector<PlaneRange<uint8_t>>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  };
  ranges.totals = bytesOf(totals);
  ranges.planes = bytesOf(elements);
  return std::make_shared<const SliceRanges>(std::move(ranges));
}

TimeStep stepOf(VolumeSource& source, WorkerPool& pool) {
  const Vec3i dims = source.layout().dims;
  PyramidLayout layout(blockLayout(dims, kBlockSize, 2));
  TimeStep step{.source = &source, .ranges = rangesOf(layout.finest(), pool)};
  for (int64_t side = 2; std::max({dims.x, dims.y, dims.z}) / side * 2 > kCoarsestVoxels;
       side *= 2) {
    const auto scale = static_cast<double>(side);
    const double offset = (scale - 1) / 2;
    const std::string reason =
        layout.add(dims / side, {{scale, scale, scale}, {offset, offset, offset}}, 2);
    if (!reason.empty()) break;
    // Levels that show what the finest one shows need no ranges (CoarserStep).
    step.coarser.push_back({.source = &source, .ranges = nullptr, .spreads = &source});
  }
  step.pyramid = std::make_shared<const PyramidLayout>(layout);
  return step;
}

// Plans of one kind.
struct Plans {
  std::vector<double> choose, seconds;
  std::vector<double> processor;  // time of all threads: other work changes it little
  size_t blocks = 0;              // of the last one

  json toJson() const {
    return {{"choose_seconds", median(choose)},
            {"seconds", median(seconds)},
            {"processor_seconds", median(processor)},
            {"blocks", blocks}};
  }
};

class CutRun {
 public:
  CutRun(const CutBench& bench, WorkerPool& pool)
      : source_(bench.dims),
        step_(stepOf(source_, pool)),
        planner_({{32, 32, 32}, 1, int64_t{1} << 16}, pool, names_),
        options_(bench.frame) {
    options_.cut = CutOptions{};
  }

  const TimeStep& step() const { return step_; }
  void showAbove(double threshold) {
    transfer_ =
        std::make_shared<const TransferFunction>(thresholdTransfer(threshold, {0, 255}, kOpacity));
  }
  void plan(double azimuth_deg, double zoom, Plans& into) {
    options_.camera.azimuth_deg = azimuth_deg;
    options_.camera.zoom = zoom;
    const View view = resolve(options_, source_.layout());
    const LookPtr look = planner_.look(step_, transfer_, options_.mode);
    const double processor_before = processorSeconds();
    const Stopwatch watch;
    const VisibleBlocksPtr blocks =
        planner_.visibleBlocks(Planner::question(step_, look, view, options_));
    into.choose.push_back(watch.seconds());
    planner_.plan(step_, blocks, options_);
    into.seconds.push_back(watch.seconds());
    into.processor.push_back(processorSeconds() - processor_before);
    into.blocks = blocks->blocks.size();
  }

 private:
  PlannedSource source_;
  const TimeStep step_;
  ChunkNames names_;
  Planner planner_;
  FrameOptions options_;
  TransferPtr transfer_;
};

// Plans pictures of a pyramid of means with spreads: an ellipsoid of nested shells. Its min-max
// arrays come from a function, and no voxel exists. Measures the first plan, plans of other
// thresholds, and plans of other views: of the whole volume, and from close by. Throws Error.
json benchCut(const CutBench& bench) {
  WorkerPool pool(bench.threads);
  CutRun run(bench, pool);
  const double azimuth = bench.frame.camera.azimuth_deg, turn = 360.0 / (bench.frames + 1);
  Plans first, thresholds, views, close_views;
  run.showAbove(kThreshold);
  run.plan(azimuth, 1, first);
  for (int i = 1; i <= bench.frames; ++i) run.plan(azimuth + turn * i, 1, views);
  for (int i = 1; i <= bench.frames; ++i) run.plan(azimuth + turn * i, kCloseUp, close_views);
  for (int i = 1; i <= bench.frames; ++i) {
    run.showAbove(kThreshold + kPlannedStep * i);
    run.plan(azimuth, 1, thresholds);
  }
  return {{"dims", {bench.dims.x, bench.dims.y, bench.dims.z}},
          {"levels", run.step().layout().levels()},
          {"volume_blocks", run.step().ranges->layout.blockCount()},
          {"ranges_bytes", run.step().ranges->bytes()},
          {"threads", pool.threads()},
          {"first", first.toJson()},
          {"threshold", thresholds.toJson()},
          {"view", views.toJson()},
          {"close_view", close_views.toJson()}};
}

void printCut(const json& report) {
  say("{} blocks in {} levels, {} MB of min-max arrays\n", report["volume_blocks"].get<int64_t>(),
      report["levels"].get<int>(), report["ranges_bytes"].get<uint64_t>() / 1'000'000);
  say("{:<18} {:>10} {:>10} {:>10} {:>8}\n", "plan", "choose ms", "ms", "CPU ms", "blocks");
  for (const auto& [name, title] : {std::pair{"first", "first"},
                                    {"threshold", "other threshold"},
                                    {"view", "other view"},
                                    {"close_view", "view from close by"}}) {
    const json& row = report[name];
    say("{:<18} {:>10.2f} {:>10.2f} {:>10.2f} {:>8}\n", title,
        1000 * row["choose_seconds"].get<double>(), 1000 * row["seconds"].get<double>(),
        1000 * row["processor_seconds"].get<double>(), row["blocks"].get<size_t>());
  }
}

}  // namespace

Bench addCutBench(CLI::App& app) {
  auto bench = std::make_shared<CutBench>();
  bench->frame = plainFrame();
  CLI::App* cut = app.add_subcommand(
      "cut",
      "Measures planning pictures of a huge volume with levels of resolution: its min-max arrays "
      "come from a function, and no voxel is read\n\n"
      "  sluice bench cut --dims 16821,7494,2070");
  constexpr NumberRange<double> kDims{128, 65536};
  const Vec3i& dims = bench->dims;
  OptionGroup(*cut, "Volume")
      .numbers(
          "--dims", "X,Y,Z", 3, kDims,
          [bench](const std::vector<double>& values) {
            for (int a = 0; a < 3; ++a)
              bench->dims[a] = static_cast<int64_t>(values[static_cast<size_t>(a)]);
          },
          "Voxels along each axis; a million blocks of 64 take 400 MB of memory",
          fmt::format("{},{},{}", dims.x, dims.y, dims.z));
  addThreadsOption(OptionGroup(*cut, kMachineHeading), bench->threads);
  addFramesOption(OptionGroup(*cut, kOutputHeading), bench->frames, "Plans measured for each kind");
  return {cut, [bench](const Show& show) { return show(benchCut(*bench), printCut); }};
}

}  // namespace sluice
