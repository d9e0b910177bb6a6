// sluice bench algorithms: Tong's Table 1 for any set of volumes, and the bytes that the texture
// cache moved.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cache/simulate/cost_model.h"
#include "io/web/address.h"
#include "src/base/error.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"
#include "tools/command_line/parse.h"
#include "tools/scene/open_scene.h"

namespace sluice {
namespace {

// The step by which the threshold changes to measure data processing.
constexpr double kThresholdStep = 1.02;

// Share of the voxels that the transfer function makes invisible, counted voxel by voxel.
double emptyPercent(const IndexedVolume& volume, const TransferFunction& transfer, int64_t time) {
  const VolumeLayout& layout = volume.source->layout();
  const OpacityTable table(transfer, volume.map, volume.index->ranges.device_range);
  int64_t empty = 0;
  for (int64_t z = 0; z < layout.dims.z; ++z) {
    const Box3 plane{{0, 0, z}, {layout.dims.x, layout.dims.y, z + 1}};
    const auto count = static_cast<size_t>(plane.count());
    std::vector<std::byte> stored(count * bytesPerVoxel(layout.type));
    volume.source->readRegion(time, plane, stored);
    std::vector<std::byte> device(count * bytesPerVoxel(volume.map.type));
    toDevice(layout.type, stored, device);
    visitDeviceType(volume.map.type, [&](auto tag) {
      const auto* voxels = reinterpret_cast<const decltype(tag)*>(device.data());
      for (size_t i = 0; i < count; ++i)
        empty += table.opacity()[static_cast<size_t>(table.entryOf(voxels[i]))] > 0 ? 0 : 1;
    });
  }
  return 100.0 * static_cast<double>(empty) / static_cast<double>(sluice::volume(layout.dims));
}

struct Measured {
  double seconds = 0;
  FrameReport report;
};

Measured measure(Session& session, FrameOptions options, Algorithm algorithm, int frames) {
  options.algorithm = algorithm;
  options.skipping = Skipping::kShading;
  session.setOptions(options);
  std::vector<double> seconds;
  Measured result;
  for (int i = -kWarmFrames; i < frames; ++i) {
    result.report = session.frameReport();
    if (i >= 0) seconds.push_back(result.report.seconds);
  }
  std::sort(seconds.begin(), seconds.end());
  result.seconds = seconds[seconds.size() / 2];
  return result;
}

// Classifies, plans with all merges, and copies the changed parts of the new plan.
double processingSeconds(Scene& scene, const LookArguments& look, const FrameOptions& options) {
  LookArguments changed = look;
  if (changed.threshold) changed.threshold = *changed.threshold * kThresholdStep;
  scene.session->setOptions(options);
  scene.session->setTransferFunction(changed.threshold ? transferFor(scene.volume, changed)
                                                       : scene.look.transfer);
  const StageSeconds stages = scene.session->frameReport().stages;
  return stages.classify + stages.plan + stages.copy;
}

nlohmann::json rowOf(const BenchArguments& bench, const std::string& word) {
  const auto [file, threshold] = splitThreshold(word, bench.look.threshold);
  LookArguments look = bench.look;
  look.threshold = threshold;
  Scene scene =
      openScene({{file}, bench.volume.open, bench.volume.time}, look, bench.resources, bench.frame);
  warnOfIdle(bench, scene, bench.frame, {"--algorithm"});
  nlohmann::json row{
      {"volume", withoutSecrets(file)},
      {"threshold", threshold ? nlohmann::json(*threshold) : nlohmann::json()},
      {"empty_percent", emptyPercent(scene.volume, scene.look.transfer, bench.volume.time)}};
  const auto page_bytes = static_cast<uint64_t>(scene.page.pageBytes());
  for (const Algorithm algorithm : kAlgorithms) {
    const Measured measured = measure(*scene.session, bench.frame, algorithm, bench.frames);
    const std::string key(name(algorithm));
    const FrameReport& report = measured.report;
    row["seconds"][key] = measured.seconds;
    row["chunks"][key] = report.chunks;
    row["pages"][key] = report.pages;
    row["pages_loaded"][key] = report.pages_loaded;
    row["binds"][key] = report.binds;
    row["uploaded_bytes"][key] = report.uploaded_bytes;
    row["modelled_seconds"][key] =
        octaneCosts().seconds(report.pages_loaded * page_bytes, report.pages_loaded, report.binds);
  }
  const double i = row["seconds"]["conventional"], iv = row["seconds"]["merged"];
  row["saved_percent"] = 100 * (i - iv) / i;
  FrameOptions merged = bench.frame;
  merged.algorithm = Algorithm::kMerged;
  row["processing_seconds"] = processingSeconds(scene, look, merged);
  return row;
}

// {"rows": [...]}: one object a volume, the names of the interface. Throws Error.
nlohmann::json benchAlgorithms(const BenchArguments& bench) {
  nlohmann::json rows = nlohmann::json::array();
  for (const std::string& word : bench.volume.inputs) rows.push_back(rowOf(bench, word));
  return {{"rows", rows}};
}

void printAlgorithms(const nlohmann::json& report) {
  say("{:<28} {:>6} {:>8} {:>8} {:>8} {:>8} {:>6} {:>10}\n", "volume", "empty%", "I s", "II s",
      "III s", "IV s", "S%", "processing");
  for (const auto& row : report["rows"]) {
    const auto& s = row["seconds"];
    say("{:<28} {:>6.1f} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f} {:>6.1f} {:>10.4f}\n",
        row["volume"].get<std::string>(), row["empty_percent"].get<double>(),
        s["conventional"].get<double>(), s["clipped"].get<double>(), s["trimmed"].get<double>(),
        s["merged"].get<double>(), row["saved_percent"].get<double>(),
        row["processing_seconds"].get<double>());
    for (const char* what : {"chunks", "pages", "pages_loaded", "binds", "uploaded_bytes"}) {
      const auto& v = row[what];
      say("  {:<26} {:>6} {:>8} {:>8} {:>8} {:>8}\n", what, "", v["conventional"].get<int64_t>(),
          v["clipped"].get<int64_t>(), v["trimmed"].get<int64_t>(), v["merged"].get<int64_t>());
    }
    const auto& m = row["modelled_seconds"];
    say("  {:<26} {:>6} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.4f}\n", "modelled Octane seconds", "",
        m["conventional"].get<double>(), m["clipped"].get<double>(), m["trimmed"].get<double>(),
        m["merged"].get<double>());
  }
}

}  // namespace

// The paper's machine and picture, unless told otherwise.
Bench addAlgorithmsBench(CLI::App& app) {
  auto bench = std::make_shared<BenchArguments>();
  bench->frame = plainFrame();
  bench->resources.page_vox = {32, 64, 2};
  bench->resources.pages = 256;
  bench->frame.size = {400, 400};
  CLI::App* algorithms = app.add_subcommand(
      "algorithms", std::string("Tong's Table 1: I conventional, II clipped, III trimmed, IV "
                                "merged\n\n") +
                        kPlainPicture +
                        "  sluice bench algorithms bonsai.nii.gz@40 engine.nii.gz@80");
  addFrames(*algorithms, *bench, kFramesOfEachWay);
  return {algorithms,
          [bench](const Show& show) { return show(benchAlgorithms(*bench), printAlgorithms); }};
}

}  // namespace sluice
