// The benches of `sluice bench`: each is a subcommand that measures something and makes one JSON
// report. bench_command.cpp runs them: it gives each --report and --json, checks the files, and
// prints or writes the report.
//
// A new bench is a source with a function that adds its subcommand, and two lines at the end here.
#pragma once

#include <nlohmann/json.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/library/drawing/scene/scene.h"
#include "tools/options/shared_options.h"

namespace sluice {

// The arguments of most benches. A bench with more derives from it.
struct BenchArguments {
  VolumeArguments volume;  // of benches over several volumes: each is FILE or FILE@THRESHOLD
  LookArguments look;      // the threshold of volumes that have none of their own
  FrameOptions frame;
  ResourceArguments resources;
  int frames = 9;                 // measured, after kWarmFrames
  const CLI::App* app = nullptr;  // the command, once addPictures() has its options
};

// Frames that a bench draws before the first that it measures.
inline constexpr int kWarmFrames = 2;

// Outputs a bench's report as the options ask; the result is the exit status.
using Print = void (*)(const nlohmann::json&);
using Show = std::function<int(nlohmann::json report, Print print)>;

// A subcommand of bench, and the function that runs it.
struct Bench {
  CLI::App* app;
  std::function<int(const Show&)> run;
  bool shows_channels = false;  // of a volume, several together; others measure one
};

// The picture that every bench draws by default, comparable over versions and with other renderers,
// and its description for help.
FrameOptions plainFrame();
extern const char* const kPlainPicture;

// Arguments of the same picture after Li: lit, modulated by the gradient, half a voxel between
// slices.
template <class Arguments>
std::shared_ptr<Arguments> litBench() {
  auto bench = std::make_shared<Arguments>();
  bench->frame = plainFrame();
  bench->frame.step_vox = 0.5;
  bench->look.shade = bench->look.modulate = true;
  return bench;
}

// Throws a usage error for light that does not follow opacities that depend on gradients, as those
// of such benches do.
void requireNoLightAround(const BenchArguments& bench);

// Options of the pictures, for every bench that draws.
AskedView addPictures(CLI::App& app, BenchArguments& arguments);
// The same with --frames, whose help is `which`.
void addFrames(CLI::App& app, BenchArguments& arguments, const char* which);
inline constexpr const char* kFramesOfEachWay =
    "Frames measured for each variant, after 2 warm ones";
inline constexpr const char* kFrames = "Frames measured, after 2 warm ones";

// Options that each row of a bench sets itself, such as "--algorithm".
using OwnOptions = std::set<std::string>;
// A line for each option that was given for nothing: frames of the scene, or the rows, leave it
// without effect (idle_options.h).
std::vector<std::string> idleLines(const BenchArguments& bench, const Scene& scene,
                                   const FrameOptions& frame, const OwnOptions& of_rows = {});
// Prints them and the warnings of the look. Every bench that draws a scene calls it.
void warnOfIdle(const BenchArguments& bench, const Scene& scene, const FrameOptions& frame,
                const OwnOptions& of_rows = {});

// "bonsai.nii.gz@40" -> the file and 40; a file without one keeps `threshold`.
std::pair<std::string, std::optional<double>> splitThreshold(const std::string& word,
                                                             std::optional<double> threshold);
// Requires: values not empty.
double median(std::vector<double> values);

// The benches, in the order of --help. Each adds its subcommand to `app`.
Bench addLimitBench(CLI::App& app);       // this machine's sampling rate
Bench addRenderBench(CLI::App& app);      // frames of a turn
Bench addSimulatorBench(CLI::App& app);   // the simulator's speed
Bench addSlicingBench(CLI::App& app);     // cutting boxes by slices
Bench addAlgorithmsBench(CLI::App& app);  // Tong's Table 1
Bench addSkippingBench(CLI::App& app);    // Li's Table 1
Bench addOcclusionBench(CLI::App& app);   // Li's Table 2 and Figure 6
Bench addCullingBench(CLI::App& app);     // Gao's figures and Table 1
Bench addLevelsBench(CLI::App& app);      // coarser levels of resolution
Bench addQualityBench(CLI::App& app);     // ways to sample rays
Bench addChannelsBench(CLI::App& app);    // several channels beside each alone
Bench addCutBench(CLI::App& app);         // plans of huge volumes
Bench addRanksBench(CLI::App& app);       // a picture shared among ranks
Bench addThresholdBench(CLI::App& app);   // from a changed transfer function to the picture
Bench addPackingBench(CLI::App& app);     // codecs of blocks in memory
Bench addWindowBench(CLI::App& app);      // a drag in a window

inline constexpr Bench (*kBenches[])(CLI::App&) = {
    addLimitBench,      addRenderBench,    addSimulatorBench, addSlicingBench,
    addAlgorithmsBench, addSkippingBench,  addOcclusionBench, addCullingBench,
    addLevelsBench,     addQualityBench,   addChannelsBench,  addCutBench,
    addRanksBench,      addThresholdBench, addPackingBench,   addWindowBench};

}  // namespace sluice
