#include <fmt/format.h>

#include <algorithm>

#include "src/library/conversions.h"
#include "src/options/option_table.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/parse.h"
#include "tools/options/shared_options.h"

namespace sluice {
namespace {

Box3 cropOf(const PictureOptions::Box& box) {
  return {{box.lo[0], box.lo[1], box.lo[2]}, {box.hi[0], box.hi[1], box.hi[2]}};
}

// Options that say how a frame is drawn.
TableOptions frameTable(CLI::App& app, const AskedView& asked, FrameOptions& options) {
  return {app, asked, [&options](const ViewState& state) {
            setDrawing(state, options);
            if (state.crop) options.crop = cropOf(*state.crop);
            // This runs for each option that is given, and planes must not add up.
            options.clip_planes.clear();
            for (const auto& [n, offset] : state.clip_planes)
              options.clip_planes.push_back({{n[0], n[1], n[2]}, offset});
          }};
}

void addCameraOptions(CLI::App& app, const AskedView& asked, Camera& camera) {
  const OptionEntry& from = optionEntry("--view");
  // The commands differ in the view that they begin with.
  from.set(*asked, std::string(name(camera.view)));
  asked->view.azimuth_deg = camera.azimuth_deg;
  asked->view.elevation_deg = camera.elevation_deg;
  const auto take = [&camera](const ViewState& state) { camera = cameraOf(state.view); };
  const TableOptions options(app, asked, take);
  options.add("--projection");
  std::vector<std::string> views(from.kind.words.begin(), from.kind.words.end());
  std::rotate(views.begin(), views.begin() + 1, views.end());  // plain is the last
  OptionGroup(app, std::string(kViewHeading))
      .word(
          "--view", views,
          [&from, take, asked](const std::string& word) {
            from.set(*asked, word);
            take(*asked);
          },
          "Start of the camera: " + listed(views) + ", along -z with +y up whatever the axes mean",
          std::string(name(camera.view)));
  options.add("--azimuth");
  options.add("--elevation");
  options.add("--zoom");
  options.add("--fov");
  options.add("--eye");
  options.add("--target");
  options.addRest(kViewHeading, OptionPart::kCamera);
}

void addDrawingOptions(CLI::App& app, const AskedView& asked, FrameOptions& options) {
  OptionGroup(app, std::string(kDrawingHeading))
      .parsed(
          "-s,--size", "WxH", "WxH or one number for both, in whole pixels", parsePictureSize,
          [&options](PictureSize size) { options.size = size; },
          "Width and height in pixels; one number stands for both",
          fmt::format("{}x{}", options.size.width, options.size.height));
  const TableOptions table = frameTable(app, asked, options);
  table.add("--step", numberText(options.step_vox));
  table.addRest(kDrawingHeading, OptionPart::kTop);
  table.addRest(kLightHeading, OptionPart::kTop);
}

}  // namespace

void addFrameOptions(CLI::App& app, const AskedView& asked, FrameOptions& options) {
  const OptionGroup rare = OptionGroup(app, std::string(kDrawingHeading)).rare();
  rare.choice(
      "--algorithm", wordsOf<Algorithm>(kAlgorithms, [](Algorithm each) { return name(each); }),
      options.algorithm, "How blocks are trimmed and merged: algorithms I to IV of Tong 1999");
  rare.choice("--merge",
              wordsOf<MergeOrder>(kMergeOrders, [](MergeOrder each) { return name(each); }),
              options.merge_order, "Order of the merge operations");
  rare.choice("--partition",
              wordsOf<Partition>(kPartitions, [](Partition each) { return name(each); }),
              options.partition,
              "Draws the object box of each block, or its visible growing boxes, which are "
              "computed once for a volume and kept with its index");
  rare.choice("--occlusion",
              wordsOf<Occlusion>(kOcclusions, [](Occlusion each) { return name(each); }),
              options.occlusion,
              "Skips hidden parts: cull skips hidden boxes, clip also skips hidden parts of "
              "boxes; map makes the opacity map but skips nothing");
  frameTable(app, asked, options).add("--opacity-threshold");
}

void addTimeLimit(CLI::App& app, const AskedView& asked, FrameOptions& options) {
  frameTable(app, asked, options).add("--time-limit");
}

void addViewOptions(CLI::App& app, const AskedView& asked, FrameOptions& options) {
  options.stop = interruption();
  addCameraOptions(app, asked, options.camera);
  addDrawingOptions(app, asked, options);
}

AskedView addPictureOptions(CLI::App& app, LookArguments& look, FrameOptions& frame,
                            FitChoice& fit) {
  auto asked = std::make_shared<ViewState>();
  look.first_picture = true;
  addLookOptions(app, asked, look, frame);
  // A first look from an oblique direction shows three sides of the volume.
  frame.camera.view = ViewName::kThreeQuarter;
  addViewOptions(app, asked, frame);
  CLI::Option* step = app.get_option("--step");
  // The distance of slices is chosen from the picture if nobody gives it.
  step->default_str("");
  step->description(step->get_description() +
                    " (1, or less if pixels are smaller than voxels or the picture is lit)");
  TableOptions(app, asked, [&fit](const ViewState& state) {
    fit = fitChoice(state.view);
  }).add("--fit", "", std::string(kViewHeading));
  return asked;
}

}  // namespace sluice
