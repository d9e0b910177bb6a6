#include "src/view/state/option_table.h"

#include <algorithm>
#include <array>
#include <utility>

#include "src/base/error.h"
#include "src/base/looks/view_limits.h"
#include "src/view/state/option_members.h"

namespace sluice {
namespace {

using Look = LookOptions;
using View = ViewOptions;
using Form = OptionForm;
using Words = OptionWords;

constexpr NumberRange<double> kWorld{-1e15, 1e15}, kShare{0, 1};

OptionKind wordOf(Words words) {
  return {.form = Form::kWord, .words = std::move(words)};
}

// `held`: the member of a view, constant or not.
template <class Held>
OptionEntry holding(OptionEntry entry, Held held) {
  entry.get = [words = entry.kind.words, held](const ViewState& state) {
    return readMember(words, held(state));
  };
  entry.set = [words = entry.kind.words, held](ViewState& state, const OptionValue& value) {
    writeMember(words, value, held(state));
  };
  return entry;
}

template <class T>
OptionEntry in(T ViewState::*member, OptionEntry entry) {
  return holding(
      std::move(entry), [=](auto& state) -> auto& { return state.*member; });
}
template <class T>
OptionEntry in(T View::*member, OptionEntry entry) {
  entry.part = OptionPart::kCamera;
  return holding(
      std::move(entry), [=](auto& state) -> auto& { return state.view.*member; });
}
template <class T>
OptionEntry in(T Look::*member, OptionEntry entry) {
  entry.part = OptionPart::kLook;
  return holding(
      std::move(entry), [=](auto& state) -> auto& { return state.look.*member; });
}
template <class T>
OptionEntry in(T PictureOptions::Lighting::*member, OptionEntry entry) {
  return holding(
      std::move(entry), [=](auto& state) -> auto& { return state.lighting.*member; });
}
// One end of the line of sight.
OptionEntry in(std::array<double, 3> View::LookAt::*member, OptionEntry entry) {
  entry.part = OptionPart::kCamera;
  entry.get = [=](const ViewState& state) -> std::optional<OptionValue> {
    if (!state.view.look_at) return std::nullopt;
    return readMember({}, *state.view.look_at.*member);
  };
  entry.set = [=](ViewState& state, const OptionValue& value) {
    if (!state.view.look_at) state.view.look_at.emplace();
    writeMember({}, value, *state.view.look_at.*member);
  };
  return entry;
}

bool hasNoPlace(const ViewState& state) {
  return !state.view.look_at;
}
bool hasPerspective(const ViewState& state) {
  return state.view.projection == View::Projection::kPerspective;
}
bool hasLabelsOfAnyKind(const ViewState& state) {
  return state.look.labels || !state.look.label_table.empty() || !state.look.label_looks.empty();
}
bool hasLabels(const ViewState& state) {
  return state.look.labels;
}
// Points take the place of all other ways to give opacities, and a file that of a ramp and labels.
bool hasNoPoints(const ViewState& state) {
  return state.look.opacities.empty();
}
bool hasNoFile(const ViewState& state) {
  return hasNoPoints(state) && state.look.transfer_file.empty();
}
bool hasRamp(const ViewState& state) {
  return hasNoFile(state) && !hasLabelsOfAnyKind(state);
}
bool hasColors(const ViewState& state) {
  return state.look.mode == Look::Mode::kComposite;
}
// The opacity is for ramps and labels; modes that show values take it with a threshold alone.
bool hasOneOpacity(const ViewState& state) {
  return hasNoFile(state) &&
         (hasColors(state) || state.look.threshold || hasLabelsOfAnyKind(state));
}
bool hasQuality(const ViewState& state) {
  return state.quality != PictureOptions::Quality::kPlain;
}
bool isIntegrated(const ViewState& state) {
  return hasQuality(state) && hasColors(state) && state.look.surfaces.empty() &&
         !hasLabelsOfAnyKind(state);
}
bool mayBeLit(const ViewState& state) {
  return hasColors(state) && state.look.light != Look::Light::kOff;
}
bool isAttenuated(const ViewState& state) {
  return state.look.mode == Look::Mode::kAttenuatedMaximum;
}
// The other modes take values of the voxel planes.
bool hasSlices(const ViewState& state) {
  return hasColors(state) || isAttenuated(state) || state.look.mode == Look::Mode::kAverage;
}
bool isBlended(const ViewState& state) {
  return state.look.combine == LookOptions::Combine::kBlend;
}
bool isLater(const ViewState& state) {
  return state.time != 0;
}

std::vector<OptionEntry> makeTable() {
  const OptionKind factor{Form::kNumber, {0, 1e6, true}}, place{Form::kPlace, kWorld};
  const OptionKind degrees{Form::kNumber, {-36000, 36000}, "degrees"};  // a hundred turns
  const OptionKind light{.form = Form::kWord,
                         .words = {"chosen", "on", "off"},
                         .flags = {"", "--shade", "--no-shade"}};
  const Words views{"plain", "front", "back", "left", "right", "top", "bottom", "three-quarter"};
  return {
      in(&View::projection, {"projection", "--projection", 20, wordOf({"ortho", "perspective"}), "",
                             "Projection of the camera"}),
      in(&View::zoom, {"zoom",
                       "--zoom",
                       28,
                       {Form::kNumber, {kLeastZoom, kMostZoom}},
                       "FACTOR",
                       "Magnification; 1 shows everything that --fit names"}),
      in(&View::field_of_view_deg, {"fov",
                                    "--fov",
                                    29,
                                    {Form::kNumber, {kLeastFieldOfViewDeg, 179}},
                                    "DEGREES",
                                    "Vertical field of view of a perspective camera",
                                    nullptr,
                                    hasPerspective}),
      in(&View::up, {"up",
                     "--up",
                     27,
                     {Form::kDirection, kWorld},
                     "X,Y,Z",
                     "Up direction in the world (the view's)"}),
      in(&View::LookAt::eye,
         {"eye", "--eye", 21, place, "X,Y,Z", "Camera position in the world, with --target"}),
      in(&View::LookAt::target, {"target", "--target", 22, place, "X,Y,Z",
                                 "World position that the camera looks at, with --eye"}),
      in(&View::from, {"view", "--view", 23, wordOf(views), "", "", hasNoPlace}),
      in(&View::azimuth_deg, {"azimuth", "--azimuth", 24, degrees, "DEGREES",
                              "Turns the camera from the view about the up axis", hasNoPlace}),
      in(&View::elevation_deg, {"elevation", "--elevation", 25, degrees, "DEGREES",
                                "Lifts the camera from the view", hasNoPlace}),
      in(&View::fit, {"fit", "--fit", 26, wordOf({"visible", "volume"}), "",
                      "Fits the visible part into the picture, over all steps of a series unless "
                      "--this-step, or the volume's sphere (visible; with --view plain volume)",
                      hasNoPlace}),

      in(&Look::mode,
         {"mode", "--mode", 12,
          wordOf({"composite", "mip", "minip", "average", "attenuated-mip", "depth-mip"}), "",
          "How the samples along a ray are combined: composite, mip, minip, average, "
          "attenuated-mip "
          "or depth-mip"}),
      in(&Look::attenuation,
         {"attenuation",
          "--attenuation",
          8,
          {Form::kNumber, {0, 1000}},
          "A",
          "--mode attenuated-mip: a voxel length at the top of --range dims values behind it by "
          "exp(-A); lower values dim in proportion (0.05)",
          nullptr,
          isAttenuated}),
      in(&Look::light, {"light", "--shade", 7, light, "", "", nullptr, hasColors}),
      in(&Look::threshold, {"threshold",
                            "--threshold",
                            3,
                            {},
                            "VALUE",
                            "Opacity 0 below this value, and a ramp above it",
                            nullptr,
                            hasRamp}),
      in(&Look::opacity, {"opacity",
                          "--opacity",
                          4,
                          {Form::kNumber, kShare},
                          "A",
                          "Opacity per voxel length at the top of a ramp (0.05), or of all labels; "
                          "automatic opacities change in proportion to it",
                          nullptr,
                          hasOneOpacity}),
      in(&Look::opacities,
         {"opacities",
          "--opacities",
          1,
          {Form::kPoints},
          "V:A,V:A,...",
          "Opacities per voxel length at these values, linear in between; with --transfer they "
          "replace the opacities of the file, whose colours stay"}),
      in(&Look::transfer_file, {"transfer",
                                "--transfer",
                                0,
                                {Form::kFile},
                                "FILE",
                                "Transfer function: our JSON or ParaView's colour map"}),
      in(&Look::labels, {"labels", "--labels", 2, {Form::kFlag}, "", "", hasLabels, hasNoFile}),
      in(&Look::label_table, {"label_table",
                              "--labels-table",
                              2,
                              {Form::kFile},
                              "FILE",
                              "Names, colours and opacities of labels, as ITK-SNAP or 3D Slicer "
                              "writes them; other labels do not show",
                              nullptr,
                              hasNoFile}),
      in(&Look::label_looks,
         {"label_looks",
          "--label",
          2,
          {Form::kLabels},
          "N=COLOR[:A]",
          "Colour and opacity per voxel length of label N, of labels N-M or of all; may be given "
          "again",
          nullptr,
          hasNoFile}),
      in(&Look::map, {"map", "--map", 5, {Form::kText}}),
      in(&Look::range,
         {"range",
          "--range",
          6,
          {Form::kRange},
          "LO,HI",
          "Value range for colours and ramps (the range of the data, over all steps of a series)"}),
      in(&Look::channels,
         {"channels",
          "--look",
          10,
          {Form::kChannels},
          "C:COLOR[,LO:HI[,A]]",
          "The look of channel C: a colour, a map or 'labels', and the values over which its "
          "opacity rises from 0 to A; once for each channel; C is 'over' for the volume of --over "
          "(from the file, else automatic)"}),
      in(&Look::combine,
         {"combine", "--combine", 11, wordOf({"add", "blend"}), "",
          "Adds the pictures of several channels, or blends all of them at each sample", nullptr,
          isBlended}),
      in(&Look::surfaces,
         {"surfaces",
          "--iso",
          8,
          {Form::kSurfaces},
          "T[:A[:COLOR]],...",
          "Draws lit surfaces at these values, with opacity A (1) and a colour (the map's); the "
          "volume "
          "is drawn, too, with --threshold, --transfer, --opacities or --opacity"}),
      in(&Look::full_gradient,
         {"full_gradient",
          "--full-gradient",
          8,
          {.limits = factor.limits, .needs = "--modulate"},
          "SHARE",
          "Gradient magnitude at which the ramp of --modulate reaches 1, as a share of the "
          "value range per voxel length",
          nullptr,
          hasColors}),

      in(&ViewState::time,
         {"time", "--time", 40, {Form::kWhole, {0}, "a time step"}, "", "", nullptr, isLater}),
      in(&ViewState::step_vox,
         {"step", "--step", 41, factor, "VOXELS",
          "Distance between slices in voxels of the finest spacing", nullptr, hasSlices}),
      in(&ViewState::quality,
         {"quality", "--quality", 46, wordOf({"plain", "fast", "normal", "high"}), "",
          "How rays are sampled: plain takes single values; fast, normal and high take all values "
          "between samples, at 2, 1 and 1/2 times the chosen step",
          hasQuality, isIntegrated}),
      in(&ViewState::jitter,
         {"jitter",
          "--jitter",
          46,
          {.form = Form::kNumber, .limits = kShare, .bare = "1"},
          "SHARE",
          "Moves the samples of each ray by up to half their distance (--jitter=SHARE: by less), "
          "which turns rings into fine grain",
          nullptr,
          hasColors}),
      in(&PictureOptions::Lighting::key,
         {"key_light",
          "--light",
          47,
          {Form::kAngles, {-36000, 36000}, "degrees"},
          "AZIMUTH,ELEVATION",
          "Where the key light of lit pictures comes from: degrees to the viewer's right and "
          "upwards (-22,29)",
          nullptr,
          mayBeLit}),
      in(&PictureOptions::Lighting::ambient,
         {"ambient",
          "--ambient",
          48,
          {Form::kNumber, kShare},
          "SHARE",
          "Share of the colour that lit samples show in any light (0.3)",
          nullptr,
          mayBeLit}),
      in(&PictureOptions::Lighting::diffuse,
         {"diffuse",
          "--diffuse",
          49,
          {Form::kNumber, kShare},
          "SHARE",
          "Share of the colour that a surface shows facing a light (0.65)",
          nullptr,
          mayBeLit}),
      in(&PictureOptions::Lighting::specular, {"specular",
                                               "--specular",
                                               50,
                                               {Form::kNumber, kShare},
                                               "SHARE",
                                               "Brightness of highlights (0.2)",
                                               nullptr,
                                               mayBeLit}),
      in(&PictureOptions::Lighting::shadows,
         {"shadows",
          "--shadows",
          51,
          {.form = Form::kNumber, .limits = kShare, .bare = "1"},
          "SHARE",
          "Matter casts shadows in the key light of lit pictures; SHARE, 0 to 1, is the part of "
          "that light taken away (1)",
          nullptr,
          mayBeLit}),
      in(&PictureOptions::Lighting::occlusion,
         {"occlusion_light",
          "--occlusion-light",
          52,
          {.form = Form::kNumber, .limits = kShare, .bare = "1"},
          "SHARE",
          "Matter around a place keeps other light away from it (ambient occlusion); SHARE, 0 to "
          "1, "
          "is the part kept away (1)",
          nullptr,
          mayBeLit}),
      in(&PictureOptions::Lighting::depth_cueing,
         {"depth_cueing",
          "--depth-cueing",
          53,
          {.form = Form::kNumber, .limits = kShare, .bare = "1"},
          "SHARE",
          "Darkens distant parts, lit or not; SHARE, 0 to 1, is how much the farthest visible part "
          "is darkened (1: black)",
          nullptr,
          hasColors}),
      in(&ViewState::crop, {"crop",
                            "--crop",
                            42,
                            {Form::kBox},
                            "X0,Y0,Z0,X1,Y1,Z1",
                            "Shows the voxels between these planes, the upper ones not included"}),
      in(&ViewState::clip_planes,
         {"clip",
          "--clip",
          43,
          {Form::kPlanes, kWorld},
          "A,B,C,D",
          "Shows world positions with a x + b y + c z <= d; may be given up to 6 times"}),
      in(&ViewState::background, {"background",
                                  "--background",
                                  44,
                                  {Form::kColor, kShare},
                                  "RRGGBB",
                                  "Background colour; without it, PNG keeps alpha"}),
      in(&ViewState::cross, {"cross", "", 0, {Form::kVoxel, {0}, "a voxel"}}),
      in(&ViewState::shows_slices, {"slices", "", 0, {Form::kFlag}}),
  };
}

}  // namespace

size_t numbersOf(OptionForm form) {
  switch (form) {
    case Form::kRange:
    case Form::kAngles:
    case Form::kPoints:
      return 2;
    case Form::kPlace:
    case Form::kDirection:
    case Form::kColor:
    case Form::kVoxel:
      return 3;
    case Form::kPlanes:
      return 4;
    case Form::kBox:
      return 6;
    default:
      return 0;
  }
}

const std::vector<OptionEntry>& optionTable() {
  static const std::vector<OptionEntry> table = makeTable();
  return table;
}

const OptionEntry& optionEntry(std::string_view option) {
  const auto& table = optionTable();
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&](const OptionEntry& entry) { return entry.option == option; });
  SLUICE_CHECK(found != table.end());
  return *found;
}

std::optional<OptionValue> savedValue(const OptionEntry& entry, const ViewState& state) {
  if (entry.is_saved != nullptr && !entry.is_saved(state)) return std::nullopt;
  return entry.get(state);
}

}  // namespace sluice
