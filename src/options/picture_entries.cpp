// The table of options: what a picture shows of its volume, in which light, and how it is made.
#include "src/options/option_entries.h"

namespace sluice {
namespace {

using Picture = PictureOptions;
using Lighting = PictureOptions::Lighting;
using Form = OptionForm;

// Rays of single values are the default, with which views are saved without the word.
bool hasQuality(const ViewState& state) {
  return state.quality != Picture::Quality::kPlain;
}
// Samples of surfaces and labels are not integrated, so that the quality changes nothing there.
bool isIntegrated(const ViewState& state) {
  return hasQuality(state) && hasColors(state) && state.look.surfaces.empty() &&
         !hasLabelsOfAnyKind(state);
}
// Light that is not asked for may still be chosen with the look, so only a refusal hides it.
bool mayBeLit(const ViewState& state) {
  return hasColors(state) && state.look.light != LookOptions::Light::kOff;
}
// The other modes take values of the voxel planes, and of places between them at small steps.
bool stepCounts(const ViewState& state) {
  return hasColors(state) || isAttenuated(state) ||
         state.look.mode == LookOptions::Mode::kAverage || state.step_vox.value_or(1) < 1;
}
// Commands draw step 0 without the option.
bool isLater(const ViewState& state) {
  return state.time != 0;
}

}  // namespace

std::vector<OptionEntry> pictureEntries() {
  const OptionKind share{Form::kNumber, kShareRange};
  // An effect that is named without a number is meant in full.
  const OptionKind bare_share{.form = Form::kNumber, .limits = kShareRange, .bare = "1"};
  return {
      in(&Picture::time, {.key = "time",
                          .option = "--time",
                          .turn = 40,
                          .kind = {Form::kWhole, {0}, "a time step"},
                          .is_printed = isLater}),
      in(&Picture::step_vox, {.key = "step",
                              .option = "--step",
                              .field = "step_vox",
                              .heading = kDrawingHeading,
                              .is_rare = true,
                              .turn = 41,
                              .kind = {Form::kNumber, {0, 1e6, true}},
                              .value = "VOXELS",
                              .help = "Distance between slices in voxels of the finest spacing",
                              .is_printed = stepCounts}),
      in(&Picture::quality, {.key = "quality",
                             .option = "--quality",
                             .heading = kDrawingHeading,
                             .is_rare = true,
                             .turn = 46,
                             .kind = wordOf({"plain", "fast", "normal", "high"}),
                             .help = "How rays are sampled: plain takes single values; fast, "
                                     "normal and high take all values "
                                     "between samples, at 2, 1 and 1/2 times the chosen step",
                             .is_saved = hasQuality,
                             .is_printed = isIntegrated}),
      in(&Picture::jitter, {.key = "jitter",
                            .option = "--jitter",
                            .heading = kDrawingHeading,
                            .is_light = true,
                            .is_rare = true,
                            .turn = 46,
                            .kind = bare_share,
                            .unset = 0.0,
                            .value = "SHARE",
                            .help = "Moves the samples of each ray by up to half their distance "
                                    "(--jitter=SHARE: by less), "
                                    "which turns rings into fine grain",
                            .is_printed = hasColors}),
      in(&Lighting::key,
         {.key = "key_light",
          .option = "--light",
          .field = "key",
          .heading = kLightHeading,
          .is_light = true,
          .is_rare = true,
          .turn = 47,
          .kind = {Form::kAngles, {-36000, 36000}, "degrees"},
          .unset = OptionReals{-22, 29},
          .value = "AZIMUTH,ELEVATION",
          .help =
              "Where the key light of lit pictures comes from: degrees to the viewer's right and "
              "upwards (-22,29)",
          .is_printed = mayBeLit}),
      in(&Lighting::ambient,
         {.key = "ambient",
          .option = "--ambient",
          .heading = kLightHeading,
          .is_light = true,
          .is_rare = true,
          .turn = 48,
          .kind = share,
          .unset = 0.3,
          .value = "SHARE",
          .help = "Share of the colour that lit samples show in any light (0.3)",
          .is_printed = mayBeLit}),
      in(&Lighting::diffuse,
         {.key = "diffuse",
          .option = "--diffuse",
          .heading = kLightHeading,
          .is_light = true,
          .is_rare = true,
          .turn = 49,
          .kind = share,
          .unset = 0.65,
          .value = "SHARE",
          .help = "Share of the colour that a surface shows facing a light (0.65)",
          .is_printed = mayBeLit}),
      in(&Lighting::specular, {.key = "specular",
                               .option = "--specular",
                               .heading = kLightHeading,
                               .is_light = true,
                               .is_rare = true,
                               .turn = 50,
                               .kind = share,
                               .unset = 0.2,
                               .value = "SHARE",
                               .help = "Brightness of highlights (0.2)",
                               .is_printed = mayBeLit}),
      in(&Lighting::shadows, {.key = "shadows",
                              .option = "--shadows",
                              .heading = kLightHeading,
                              .is_light = true,
                              .is_rare = true,
                              .turn = 51,
                              .kind = bare_share,
                              .unset = 0.0,
                              .value = "SHARE",
                              .help = "Matter casts shadows in the key light of lit pictures; "
                                      "--shadows=SHARE, 0 to 1, takes "
                                      "that part of the light away (1)",
                              .is_printed = mayBeLit}),
      in(&Lighting::occlusion, {.key = "occlusion_light",
                                .option = "--occlusion-light",
                                .field = "occlusion",
                                .heading = kLightHeading,
                                .is_light = true,
                                .is_rare = true,
                                .turn = 52,
                                .kind = bare_share,
                                .unset = 0.0,
                                .value = "SHARE",
                                .help = "Darkens pits and gaps in lit pictures: matter around a "
                                        "place keeps other light away (ambient occlusion); "
                                        "--occlusion-light=SHARE, 0 to 1, keeps that part away (1)",
                                .is_printed = mayBeLit}),
      in(&Lighting::depth_cueing,
         {.key = "depth_cueing",
          .option = "--depth-cueing",
          .heading = kLightHeading,
          .is_light = true,
          .is_rare = true,
          .turn = 53,
          .kind = bare_share,
          .unset = 0.0,
          .value = "SHARE",
          .help = "Darkens distant parts, lit or not, the farthest visible part to black; "
                  "--depth-cueing=SHARE, 0 to 1, darkens it by that share (1)",
          .is_printed = hasColors}),
      in(&Picture::crop,
         {.key = "crop",
          .option = "--crop",
          .heading = kDrawingHeading,
          .turn = 42,
          .kind = {Form::kBox},
          .value = "X0,Y0,Z0,X1,Y1,Z1",
          .help = "Shows only voxels X0 to X1 - 1 along x, and so on; the first voxel is 0"}),
      in(&Picture::clip_planes,
         {.key = "clip",
          .option = "--clip",
          .field = "clip_planes",
          .heading = kDrawingHeading,
          .turn = 43,
          .kind = {Form::kPlanes, kWorldRange},
          .value = "A,B,C,D",
          .help = "Shows world positions with A x + B y + C z <= D; may be given up to 6 times"}),
      in(&ViewState::background, {.key = "background",
                                  .option = "--background",
                                  .heading = kLookHeading,
                                  .turn = 44,
                                  .kind = {Form::kColor, kShareRange},
                                  .value = "RRGGBB",
                                  .help = "Background colour; without it, PNG keeps alpha"}),
      in(&Picture::opacity_threshold,
         {.key = "opacity_threshold",
          .option = "--opacity-threshold",
          .heading = kDrawingHeading,
          .is_rare = true,
          .kind = {Form::kNumber, {0, 1, true}},
          .value = "A",
          .help = "Opacity from which a ray hides everything behind it; 1 changes no picture (1; "
                  "with --occlusion or --culling 0.95)",
          .part = OptionPart::kPicture}),
      in(&Picture::time_limit_s,
         {.key = "time_limit",
          .option = "--time-limit",
          .field = "time_limit_s",
          .heading = kDrawingHeading,
          .kind = {Form::kSeconds, {0, 1e9}, "a number of seconds"},
          .value = "SECONDS",
          .help =
              "Draws the best picture that this time allows, as in 1s or 500ms, counted from the "
              "start. Of a volume with an index but without levels of resolution, blocks that "
              "are not read in time are left out, and the missing share is printed (no limit)",
          .part = OptionPart::kPicture}),
      in(&Picture::level, {.key = "level",
                           .option = "--level",
                           .heading = kLevelsHeading,
                           .is_rare = true,
                           .kind = {Form::kWhole, {0, 63}, "a whole number"},
                           .value = "N",
                           .help = "Draws this level only; 0 is the data as stored",
                           .part = OptionPart::kPicture}),
      in(&Picture::pixel_error,
         {.key = "pixel_error",
          .option = "--pixel-error",
          .heading = kLevelsHeading,
          .is_rare = true,
          .kind = {Form::kNumber, {0, 1e6, true}},
          .value = "PIXELS",
          .help = "Draws each part at the coarsest level whose voxels are at most this wide (1)",
          .part = OptionPart::kPicture}),
      in(&Picture::max_bytes, {.key = "max_bytes",
                               .option = "--max-bytes",
                               .heading = kLevelsHeading,
                               .is_rare = true,
                               .kind = {Form::kBytes, {0, 0x1p63}, "a number of bytes"},
                               .value = "BYTES",
                               .help = "Refines levels until the blocks of a picture would exceed "
                                       "this many bytes of stored voxels (no limit)",
                               .part = OptionPart::kPicture}),
      in(&Picture::keep_thin,
         {.key = "keep_thin",
          .option = "--keep-thin",
          .heading = kLevelsHeading,
          .kind = {Form::kFlag},
          .help = "Refines parts where level 0 shows something thinner than two coarse voxels",
          .part = OptionPart::kPicture}),
      // The window alone has these, so that they have no option and no help.
      in(&ViewState::cross, {.key = "cross", .kind = {Form::kVoxel, {0}, "a voxel"}}),
      in(&ViewState::shows_slices, {.key = "slices", .kind = {Form::kFlag}}),
  };
}

}  // namespace sluice
