#include "tools/bench/bench.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/library/drawing/scene/picture_facts.h"
#include "tools/command_line/console.h"
#include "tools/command_line/option_group.h"
#include "tools/command_line/parse.h"
#include "tools/command_line/usage.h"

namespace sluice {

const char* const kPlainPicture =
    "By default pictures are plain: --view plain at azimuth 30 and elevation 20, fitted to the "
    "volume's sphere, unlit, with a step of 1. Without --threshold the ramp begins at a fifth of "
    "the value range.\n\n";

FrameOptions plainFrame() {
  FrameOptions plain;
  plain.camera.azimuth_deg = 30;
  plain.camera.elevation_deg = 20;
  return plain;
}

void requireNoLightAround(const BenchArguments& bench) {
  if (bench.look.modulate && bench.frame.lighting.looksAround())
    failUsage(
        "this bench draws opacities that depend on gradients, which --shadows and "
        "--occlusion-light do not follow; leave them out");
}

AskedView addPictures(CLI::App& app, BenchArguments& arguments) {
  arguments.app = &app;
  auto asked = std::make_shared<ViewState>();
  addVolumeOptions(app, arguments.volume);
  addLookOptions(app, asked, arguments.look, arguments.frame);
  addViewOptions(app, asked, arguments.frame);
  addFrameOptions(app, asked, arguments.frame);
  addResourceOptions(app, arguments.resources);
  return asked;
}

std::vector<std::string> idleLines(const BenchArguments& bench, const Scene& scene,
                                   const FrameOptions& frame, const OwnOptions& of_rows) {
  std::set<std::string> given = givenOptions(*bench.app);
  std::vector<std::string> lines;
  for (const std::string& option : of_rows)
    if (given.erase(option) > 0)
      lines.push_back(fmt::format("{} changes nothing here: each row has its own", option));
  FrameOptions drawn = frame;
  // Rows of all algorithms merge, too.
  if (of_rows.contains("--algorithm")) drawn.algorithm = Algorithm::kMerged;
  for (const std::string& line : idleOptions(given, pictureFacts(scene, drawn)))
    lines.push_back(fmt::format("{}: {}", scene.volume.name, line));
  return lines;
}

void warnOfIdle(const BenchArguments& bench, const Scene& scene, const FrameOptions& frame,
                const OwnOptions& of_rows) {
  for (const std::string& line : scene.lookWarnings()) printWarning(line);
  for (const std::string& line : idleLines(bench, scene, frame, of_rows)) printWarning(line);
}

void addFrames(CLI::App& app, BenchArguments& bench, const char* which) {
  addPictures(app, bench);
  addFramesOption(OptionGroup(app, kOutputHeading), bench.frames, which);
}

std::pair<std::string, std::optional<double>> splitThreshold(const std::string& word,
                                                             std::optional<double> threshold) {
  const size_t at = word.rfind('@');
  if (at == std::string::npos) return {word, threshold};
  const auto number = parseNumbers(word.substr(at + 1), 1);
  if (!number) return {word, threshold};
  return {word.substr(0, at), number->front()};
}

double median(std::vector<double> values) {
  SLUICE_CHECK(!values.empty());
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

}  // namespace sluice
