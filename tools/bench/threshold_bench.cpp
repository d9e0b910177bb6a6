// sluice bench threshold: from a changed transfer function to the finished picture, and the time of
// a renderer without min-max arrays for the same.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <unordered_set>

#include "src/base/threads/clock.h"
#include "src/classify/transfer/transfer_makers.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"
#include "tools/scene/open_scene.h"

namespace sluice {
namespace {

struct ThresholdBench : BenchArguments {
  int changes = 24;  // changes of each kind
};

constexpr int kSteadyFrames = 9;
constexpr int kRebuilds = 3;
// Shares of the value range.
constexpr double kSmallStep = 1.0 / 256, kLargeStep = 1.0 / 16, kWalkStep = 1.0 / 64;
constexpr double kBandWidth = 1.0 / 8;

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  return values[static_cast<size_t>(std::lround(at))];
}

struct Range {
  double lo, hi, start;
  double span() const { return hi - lo; }
  double clamped(double threshold) const {
    // At the ends of the range nothing or everything is shown, which is no change to measure.
    return std::clamp(threshold, lo + 0.02 * span(), hi - 0.02 * span());
  }
};

// A transfer function that shows values only in a band above a threshold.
TransferFunction band(TransferFunction transfer, const Range& range, double at, double opacity) {
  const double end = at + kBandWidth * range.span();
  transfer.opacities = {{at, 0}, {at, opacity}, {end, opacity}, {end, 0}};
  transfer.name = fmt::format("band {:g} to {:g}", at, end);
  return transfer;
}

// The thresholds of one kind of change, each the change from the one before.
std::vector<double> thresholdsOf(const std::string& kind, const Range& range, int count,
                                 uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> step(0, kWalkStep * range.span());
  std::vector<double> thresholds;
  double threshold = range.start;
  for (int i = 1; i <= count; ++i) {
    // No threshold comes twice, so that none finds chunks of an earlier change by design.
    if (kind == "small" || kind == "band") threshold = range.start + kSmallStep * range.span() * i;
    if (kind == "large")
      threshold =
          range.start + range.span() * (kLargeStep * (i % 4) + kSmallStep * (0.125 + 0.25 * i));
    if (kind == "walk") threshold += step(random);
    threshold = range.clamped(threshold);
    thresholds.push_back(threshold);
  }
  return thresholds;
}

struct Changes {
  std::vector<double> seconds;
  std::vector<double> processor;  // time of all threads: other work changes it little
  // The same of each picture drawn once more, when nothing has changed.
  std::vector<double> again_seconds, again_processor;
  std::vector<double> classify, plan, copy, read, decode, upload, draw;
  uint64_t copied_bytes = 0, uploaded_bytes = 0, decoded_bytes = 0, rebuild_bytes = 0;

  void add(const FrameReport& report) {
    const StageSeconds& s = report.stages;
    classify.push_back(s.classify), plan.push_back(s.plan), copy.push_back(s.copy);
    read.push_back(s.read), decode.push_back(s.decode), upload.push_back(s.upload);
    draw.push_back(s.draw);
    copied_bytes += report.copied_bytes, uploaded_bytes += report.uploaded_bytes;
    decoded_bytes += report.decoded_bytes, rebuild_bytes += report.rebuild.copied;
  }
  nlohmann::json json() const {
    const auto p50 = [](const std::vector<double>& values) { return quantile(values, 0.5); };
    return {{"p50", p50(seconds)},
            {"p95", quantile(seconds, 0.95)},
            {"max", quantile(seconds, 1)},
            {"processor_p50", p50(processor)},
            {"again_p50", p50(again_seconds)},
            {"again_processor_p50", p50(again_processor)},
            {"parts",
             {{"classify", p50(classify)},
              {"plan", p50(plan)},
              {"read", p50(read)},
              {"decode", p50(decode)},
              {"copy", p50(copy)},
              {"upload", p50(upload)},
              {"draw", p50(draw)}}},
            {"bytes_copied", copied_bytes},
            {"bytes_uploaded", uploaded_bytes},
            {"bytes_decoded", decoded_bytes},
            {"rebuild_bytes_copied", rebuild_bytes}};
  }
};

FrameReport timedFrame(Session& session, std::vector<double>& seconds,
                       std::vector<double>& processor) {
  const double before = processorSeconds();
  const Stopwatch watch;
  FrameReport report = session.frameReport();
  seconds.push_back(watch.seconds());
  processor.push_back(processorSeconds() - before);
  return report;
}

FrameReport change(Session& session, const TransferFunction& transfer, Changes& into) {
  session.setTransferFunction(transfer);
  FrameReport report = timedFrame(session, into.seconds, into.processor);
  into.add(report);
  timedFrame(session, into.again_seconds, into.again_processor);
  return report;
}

// Counts independently the voxels that a change should copy: those of chunks whose recipe no plan
// had before.
class ChangedBytes {
 public:
  explicit ChangedBytes(Scene& scene)
      : step_(scene.volume.step()), planner_(scene.page, scene.pool, names_) {}

  uint64_t of(const TransferFunction& transfer, const FrameOptions& options) {
    const FramePlanPtr plan =
        planner_.planFor(step_, std::make_shared<const TransferFunction>(transfer), options);
    const TexturePlan& textures = plan->textures;
    uint64_t voxels = 0;
    for (const ChunkPosition i : plan->names.indices())
      if (seen_.insert(plan->names[i]).second)
        for (const BlockPosition block : textures.chunks[i].blocks)
          voxels += static_cast<uint64_t>(textures.blocks[block].voxels.count());
    return voxels * static_cast<uint64_t>(textures.page.bytes_per_voxel);
  }

 private:
  const TimeStep step_;
  ChunkNames names_;
  Planner planner_;
  std::unordered_set<ChunkName> seen_;
};

constexpr std::array kKinds = {"small", "large", "walk", "band"};

struct ThresholdRun {
  const ThresholdBench& asked;
  Scene& scene;
  Range range;

  // The transfer function of `sluice render` with this --threshold.
  TransferFunction above(double threshold) const {
    LookArguments look = asked.look;
    look.transfer_file.clear();
    look.threshold = threshold;
    return transferFor(scene.volume, look);
  }
  TransferFunction start() const { return above(range.start); }
  std::vector<TransferFunction> changes(const std::string& kind) const {
    const double opacity = asked.look.opacity.value_or(kDefaultOpacity);
    std::vector<TransferFunction> changes;
    for (const double at : thresholdsOf(kind, range, asked.changes, asked.resources.seed))
      changes.push_back(kind == "band" ? band(above(at), range, at, opacity) : above(at));
    return changes;
  }
  std::unique_ptr<Session> sessionOf(const TimeStep& step, uint64_t memory_bytes) const {
    SessionOptions options = sessionOptions(scene.volume, scene.look.lit, asked.resources,
                                            asked.frame.partition, memory_bytes);
    options.page = scene.page;
    auto session = std::make_unique<Session>(step, *scene.device, scene.pool, options);
    session->setOptions(asked.frame);
    return session;
  }
};

void measureSteadyFrame(Session& session, nlohmann::json& report) {
  std::vector<double> seconds, processor;
  for (int i = 0; i < kWarmFrames; ++i) session.frameReport();
  for (int i = 0; i < kSteadyFrames; ++i) timedFrame(session, seconds, processor);
  report["steady_frame_seconds"] = quantile(seconds, 0.5);
  report["steady_frame_processor_seconds"] = quantile(processor, 0.5);
}

// All in memory: the session holds everything that any frame so far asked for.
nlohmann::json warmChanges(const ThresholdRun& bench, nlohmann::json& report) {
  nlohmann::json result;
  ChangedBytes changed(bench.scene);
  uint64_t copied_bytes = 0, changed_bytes = 0;
  std::vector<double> classify, plan;
  Session& session = *bench.scene.session;
  const auto expected = [&](const TransferFunction& transfer) {
    return changed.of(transfer, bench.asked.frame);
  };
  // Chunks of the start are in textures already.
  expected(bench.start());
  for (const char* kind : kKinds) {
    session.setTransferFunction(bench.start());
    session.frameReport();
    Changes measured;
    for (const TransferFunction& transfer : bench.changes(kind)) {
      changed_bytes += expected(transfer);
      copied_bytes += change(session, transfer, measured).copied_bytes;
    }
    result[kind] = measured.json();
    classify.insert(classify.end(), measured.classify.begin(), measured.classify.end());
    plan.insert(plan.end(), measured.plan.begin(), measured.plan.end());
  }
  report["classify_seconds"] = quantile(classify, 0.5);
  report["plan_seconds"] = quantile(plan, 0.5);
  report["bytes_copied"] = copied_bytes;
  report["bytes_changed"] = changed_bytes;
  return result;
}

// A threshold raised by a fifth, as the peers' scripts time it: each time from a threshold of its
// own that was drawn before.
nlohmann::json raisedByAFifth(const ThresholdRun& bench) {
  Session& session = *bench.scene.session;
  Changes measured;
  for (int i = 0; i < bench.asked.changes; ++i) {
    const double start = bench.range.start * (1 + 0.003 * i);
    session.setTransferFunction(bench.above(start));
    session.frameReport();
    change(session, bench.above(1.2 * start), measured);
  }
  return measured.json();
}

// Nothing is held but the index: each change opens a session of its own.
nlohmann::json coldChanges(const ThresholdRun& bench) {
  Changes measured;
  for (const TransferFunction& transfer : bench.changes("small")) {
    const auto session = bench.sessionOf(bench.scene.volume.step(), bench.scene.memory_bytes);
    change(*session, transfer, measured);
  }
  return {{"small", measured.json()}};
}

nlohmann::json outOfCoreChanges(const ThresholdRun& bench) {
  const MovedBytes all = bench.scene.session->frameReport().rebuild;
  const DeviceLimits limits = bench.scene.device->limits();
  const PageGeometry& page = bench.scene.page;
  const uint64_t textures = textureMemoryBytes(page, limits.texels);
  const BufferNeeds needs = needsOf(bench.scene.volume.step(), bench.asked.frame.partition,
                                    bench.scene.volume.rangesBytes());
  // Less memory would be refused.
  const uint64_t least = textures + leastBufferBytes(page, needs);
  const uint64_t memory_bytes = std::max(least, textures + (all.decoded + all.uploaded) / 4);
  nlohmann::json result{{"memory_bytes", memory_bytes}};
  const auto session = bench.sessionOf(bench.scene.volume.step(), memory_bytes);
  for (const char* kind : kKinds) {
    session->setTransferFunction(bench.start());
    session->frameReport();
    Changes measured;
    for (const TransferFunction& transfer : bench.changes(kind))
      change(*session, transfer, measured);
    result[kind] = measured.json();
  }
  return result;
}

// The rebuild of a renderer without min-max arrays: every voxel is looked at, every chunk made
// again.
double rebuildSeconds(const ThresholdRun& bench) {
  std::vector<double> seconds;
  const std::vector<TransferFunction> transfers = bench.changes("small");
  for (int i = 0; i < kRebuilds; ++i) {
    const Stopwatch watch;
    ProgressMeter silent;
    TimeStep step = bench.scene.volume.step();
    step.ranges = std::make_shared<const SliceRanges>(
        buildSliceRanges(*step.source, step.time, bench.scene.volume.layout,
                         {bench.scene.pool, silent, kMostIndexingBytes}));
    const auto session = bench.sessionOf(step, bench.scene.memory_bytes);
    session->setTransferFunction(transfers[static_cast<size_t>(i) % transfers.size()]);
    session->frameReport();
    seconds.push_back(watch.seconds());
  }
  return quantile(seconds, 0.5);
}

// The names of the interface, and in addition `walk` and `band` changes, the parts of each change,
// with each picture drawn `again` and the processor's time of both, a threshold `raised_by_a_fifth`
// from ones drawn before, and the same changes `cold` (a session that holds nothing) and
// `out_of_core` (memory for a quarter of the picture's need). Throws Error.
nlohmann::json benchThreshold(const ThresholdBench& asked) {
  Scene scene = openScene(asked.volume, asked.look, asked.resources, asked.frame);
  warnOfIdle(asked, scene, asked.frame);
  const ValueRange values = scene.volume.valueRange();
  const double start = asked.look.threshold.value_or(plainThreshold(values));
  const ThresholdRun bench{asked, scene, {values.lo, values.hi, start}};
  nlohmann::json report;
  scene.session->setOptions(asked.frame);
  scene.session->setTransferFunction(bench.start());
  measureSteadyFrame(*scene.session, report);
  report["change_seconds"] = warmChanges(bench, report);
  report["raised_by_a_fifth"] = raisedByAFifth(bench);
  scene.session->setTransferFunction(bench.start());
  report["out_of_core"] = outOfCoreChanges(bench);
  report["cold"] = coldChanges(bench);
  report["rebuild_seconds"] = rebuildSeconds(bench);
  return report;
}

void printThreshold(const nlohmann::json& report) {
  const double steady = report["steady_frame_seconds"];
  const double processor = report["steady_frame_processor_seconds"];
  say("steady frame {:.4f} s, {:.4f} s of the processor's time; rebuild without min-max arrays "
      "{:.4f} s\n",
      steady, processor, report["rebuild_seconds"].get<double>());
  say("{:<22} {:>8} {:>8} {:>8} {:>7} {:>7} {:>9} {:>8} {:>8} {:>8} {:>8}\n", "changes", "p50 s",
      "p95 s", "max s", "frames", "CPU", "classify", "plan", "copy", "upload", "draw");
  const auto row = [&](const std::string& name, const nlohmann::json& m) {
    const nlohmann::json& parts = m["parts"];
    const double p50 = m["p50"];
    say("{:<22} {:>8.4f} {:>8.4f} {:>8.4f} {:>7.2f} {:>7.2f} {:>9.5f} {:>8.5f} {:>8.4f} {:>8.4f} "
        "{:>8.4f}\n",
        name, p50, m["p95"].get<double>(), m["max"].get<double>(),
        p50 / m["again_p50"].get<double>(),
        m["processor_p50"].get<double>() / m["again_processor_p50"].get<double>(),
        parts["classify"].get<double>(), parts["plan"].get<double>(), parts["copy"].get<double>(),
        parts["upload"].get<double>(), parts["draw"].get<double>());
  };
  for (const char* kind : kKinds) row(kind, report["change_seconds"][kind]);
  row("raised by a fifth", report["raised_by_a_fifth"]);
  for (const char* kind : kKinds)
    row(std::string("out of core, ") + kind, report["out_of_core"][kind]);
  row("cold, small", report["cold"]["small"]);
  say("frames, CPU: wall clock and processor's time as multiples of those of the same picture "
      "drawn again\n");
  say("in memory: {} bytes copied, {} bytes of changed chunks\n",
      report["bytes_copied"].get<uint64_t>(), report["bytes_changed"].get<uint64_t>());
}

}  // namespace

Bench addThresholdBench(CLI::App& app) {
  auto bench = std::make_shared<ThresholdBench>();
  bench->frame = plainFrame();
  bench->changes = 24;
  CLI::App* threshold = app.add_subcommand(
      "threshold",
      std::string(
          "Measures from a changed threshold to the finished picture: small and large steps, a "
          "random walk and a band; in memory, out of core and cold; and a full rebuild\n\n") +
          kPlainPicture + "  sluice bench threshold bonsai.nii.gz --threshold 40");
  addPictures(*threshold, *bench);
  OptionGroup(*threshold, kOutputHeading)
      .number("--changes", "N", bench->changes, {1, 100'000}, "Changes of each kind");
  return {threshold,
          [bench](const Show& show) { return show(benchThreshold(*bench), printThreshold); }};
}

}  // namespace sluice
