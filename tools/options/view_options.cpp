#include <fmt/format.h>

#include "tools/command_line/interrupt.h"
#include "tools/command_line/parse.h"
#include "tools/options/shared_options.h"

namespace sluice {
namespace {

// "0.5", "1s" or "500ms".
std::optional<double> parseSeconds(std::string word) {
  double unit = 1;
  if (word.ends_with("ms")) {
    unit = 1e-3;
    word.resize(word.size() - 2);
  } else if (word.ends_with("s")) {
    word.resize(word.size() - 1);
  }
  const std::optional<double> number = parseIn<double>(word, {0, 1e9});
  return number ? std::optional(*number * unit) : std::nullopt;
}

constexpr double kMostDegrees = 36000;  // a hundred turns
constexpr NumberRange<double> kWorld{-1e15, 1e15};

std::optional<Box3> cropBox(const std::string& word) {
  const auto found = parseNumbers(word, 6);
  if (!found) return std::nullopt;
  for (const double n : *found)
    if (n < 0 || n > kMostVoxels || n != static_cast<double>(static_cast<int64_t>(n)))
      return std::nullopt;
  for (size_t a = 0; a < 3; ++a)
    if ((*found)[a + 3] < (*found)[a] + 2)
      return std::nullopt;  // a single voxel plane has no thickness
  return Box3{asVec3i(*found), asVec3i({(*found)[3], (*found)[4], (*found)[5]})};
}

void addCameraOptions(const OptionGroup& group, Camera& camera) {
  group.choice(
      "--projection",
      Words<Projection>{{"ortho", Projection::kOrtho}, {"perspective", Projection::kPerspective}},
      camera.projection, "Projection of the camera");
  const auto views = wordsOf<ViewName>(
      std::array{ViewName::kFront, ViewName::kBack, ViewName::kLeft, ViewName::kRight,
                 ViewName::kTop, ViewName::kBottom, ViewName::kThreeQuarter, ViewName::kPlain},
      [](ViewName each) { return name(each); });
  CLI::Option* view = group.choice("--view", views, camera.view,
                                   "Start of the camera: " + listed(namesOf(views)) +
                                       ", along -z with +y up whatever the axes mean");
  CLI::Option* azimuth =
      group.number("--azimuth", "DEGREES", camera.azimuth_deg, {-kMostDegrees, kMostDegrees},
                   "Turns the camera from the view about the up axis");
  CLI::Option* elevation =
      group.number("--elevation", "DEGREES", camera.elevation_deg, {-kMostDegrees, kMostDegrees},
                   "Lifts the camera from the view");
  group.number("--zoom", "FACTOR", camera.zoom, {0, 1e6, true},
               "Magnification; 1 shows everything that --fit names");
  group.number("--fov", "DEGREES", camera.field_of_view_deg, {0, 179, true},
               "Vertical field of view of a perspective camera");
  const auto look_at = [&camera]() -> Camera::LookAt& {
    if (!camera.look_at) camera.look_at = Camera::LookAt{};
    return *camera.look_at;
  };
  CLI::Option* eye = group.numbers(
      "--eye", "X,Y,Z", 3, kWorld,
      [look_at](const std::vector<double>& n) { look_at().eye = asVec3d(n); },
      "Camera position in the world, with --target");
  CLI::Option* target = group.numbers(
      "--target", "X,Y,Z", 3, kWorld,
      [look_at](const std::vector<double>& n) { look_at().target = asVec3d(n); },
      "World position that the camera looks at, with --eye");
  group.numbers(
      "--up", "X,Y,Z", 3, kWorld,
      [&camera](const std::vector<double>& n) { camera.up = asVec3d(n); },
      "Up direction in the world (the view's)");
  eye->needs(target)->excludes(view)->excludes(azimuth)->excludes(elevation);
  target->needs(eye);
}

void addDrawingOptions(const OptionGroup& group, FrameOptions& options) {
  group.parsed(
      "-s,--size", "WxH", "WxH or one number for both, each from 1 to 65536", parsePictureSize,
      [&options](PictureSize size) { options.size = size; }, "Pixels",
      fmt::format("{}x{}", options.size.width, options.size.height));
  group.number("--step", "VOXELS", options.step_vox, {0, 1e6, true},
               "Distance between slices in voxels of the finest spacing");
  group.parsed(
      "--crop", "X0,Y0,Z0,X1,Y1,Z1",
      "six whole numbers X0,Y0,Z0,X1,Y1,Z1 from 0 to 2^40, each upper one at least 2 above the "
      "lower, since a single voxel plane has no thickness",
      cropBox, [&options](const Box3& box) { options.crop = box; },
      "Shows the voxels between these planes, the upper ones not included");
  group
      .numbers(
          "--clip", "A,B,C,D", 4, kWorld,
          [&options](const std::vector<double>& n) {
            if (options.clip_planes.size() == kMostClipPlanes)
              throw CLI::ValidationError("--clip: at most 6 planes");
            options.clip_planes.push_back({asVec3d(n), n[3]});
          },
          "Shows world positions with a x + b y + c z <= d; may be given up to 6 times")
      ->trigger_on_parse();
  group.choice("--algorithm",
               wordsOf<Algorithm>(std::array{Algorithm::kConventional, Algorithm::kClipped,
                                             Algorithm::kTrimmed, Algorithm::kMerged},
                                  [](Algorithm algorithm) { return name(algorithm); }),
               options.algorithm,
               "How blocks are trimmed and merged: algorithms I to IV of Tong 1999");
  group.choice(
      "--merge",
      Words<MergeOrder>{{"paper", MergeOrder::kPaper}, {"first-fit", MergeOrder::kFirstFit}},
      options.merge_order, "Order of the merge operations");
  group.choice("--partition",
               Words<Partition>{{"blocks", Partition::kBlocks}, {"boxes", Partition::kBoxes}},
               options.partition,
               "Draws the object box of each block, or its visible growing boxes, which are "
               "computed once for a volume and kept with its index");
  group.choice("--occlusion",
               Words<Occlusion>{{"off", Occlusion::kOff},
                                {"map", Occlusion::kMap},
                                {"cull", Occlusion::kCull},
                                {"clip", Occlusion::kClip}},
               options.occlusion,
               "Skips hidden parts: cull skips hidden boxes, clip also skips hidden parts of "
               "boxes; map makes the opacity map but skips nothing");
  group.number("--opacity-threshold", "A", options.opacity_threshold, {0, 1, true},
               "Opacity at which a ray ends and hides everything behind; 1 changes no picture (1; "
               "with --occlusion 0.95)");
  group.parsed(
      "--time-limit", "SECONDS", "a number from 0 to 1e+09, also with a unit, as in 1s or 500ms",
      parseSeconds, [&options](double seconds) { options.time_limit_s = seconds; },
      "Volumes with levels of resolution: the best picture of that time, counted from the start. "
      "Others: leaves out blocks that are not read in time, and prints the missing share (waits "
      "for all)");
}

}  // namespace

void addViewOptions(CLI::App& app, FrameOptions& options) {
  options.stop = interruption();
  addCameraOptions(OptionGroup(app, "View"), options.camera);
  addDrawingOptions(OptionGroup(app, "Drawing"), options);
}

void addFitOption(CLI::App& app, FitChoice& fit) {
  OptionGroup(app, "View")
      .choice("--fit", Words<Fit>{{"visible", Fit::kVisible}, {"volume", Fit::kVolume}}, fit,
              "Fits the visible part into the picture, over all steps of a series unless "
              "--this-step, or the volume's sphere (visible; with --view plain volume)")
      ->excludes(app.get_option("--eye"));
}

void addPictureOptions(CLI::App& app, LookArguments& look, FrameOptions& frame, FitChoice& fit) {
  look.first_picture = true;
  addLookOptions(app, look, frame);
  frame.camera.view = ViewName::kThreeQuarter;
  addViewOptions(app, frame);
  addFitOption(app, fit);
}

}  // namespace sluice
