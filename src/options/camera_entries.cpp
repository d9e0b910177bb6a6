// The table of options: the camera.
#include "src/base/looks/view_limits.h"
#include "src/options/option_entries.h"

namespace sluice {
namespace {

using View = ViewOptions;
using Form = OptionForm;

// An eye and a target say where the camera is, which leaves nothing for angles and fits to add.
bool hasNoPlace(const ViewState& state) {
  return !state.view.look_at;
}
// Parallel rays have no angle between them.
bool hasPerspective(const ViewState& state) {
  return state.view.projection == View::Projection::kPerspective;
}

}  // namespace

std::vector<OptionEntry> cameraEntries() {
  const OptionKind place{Form::kPlace, kWorldRange};
  const OptionKind degrees{Form::kNumber, {-36000, 36000}, "degrees"};  // a hundred turns
  const OptionWords views{"plain", "front", "back",   "left",
                          "right", "top",   "bottom", "three-quarter"};
  return {
      in(&View::projection, {.key = "projection",
                             .option = "--projection",
                             .heading = kViewHeading,
                             .turn = 20,
                             .kind = wordOf({"ortho", "perspective"}),
                             .help = "Projection of the camera"}),
      in(&View::zoom, {.key = "zoom",
                       .option = "--zoom",
                       .heading = kViewHeading,
                       .turn = 28,
                       .kind = {Form::kNumber, {kLeastZoom, kMostZoom}},
                       .value = "FACTOR",
                       .help = "Magnification; 1 shows everything that --fit names"}),
      in(&View::field_of_view_deg, {.key = "fov",
                                    .option = "--fov",
                                    .field = "field_of_view_deg",
                                    .heading = kViewHeading,
                                    .is_rare = true,
                                    .turn = 29,
                                    .kind = {Form::kNumber, {kLeastFieldOfViewDeg, 179}},
                                    .value = "DEGREES",
                                    .help = "Vertical field of view of a perspective camera",
                                    .is_printed = hasPerspective}),
      in(&View::up, {.key = "up",
                     .option = "--up",
                     .heading = kViewHeading,
                     .is_rare = true,
                     .turn = 27,
                     .kind = {Form::kDirection, kWorldRange},
                     .value = "X,Y,Z",
                     .help = "Up direction in the world (the view's)"}),
      in(&View::LookAt::eye, {.key = "eye",
                              .option = "--eye",
                              .heading = kViewHeading,
                              .is_rare = true,
                              .turn = 21,
                              .kind = place,
                              .value = "X,Y,Z",
                              .help = "Camera position in the world, with --target"}),
      in(&View::LookAt::target, {.key = "target",
                                 .option = "--target",
                                 .heading = kViewHeading,
                                 .is_rare = true,
                                 .turn = 22,
                                 .kind = place,
                                 .value = "X,Y,Z",
                                 .help = "World position that the camera looks at, with --eye"}),
      in(&View::from, {.key = "view",
                       .option = "--view",
                       .field = "from",
                       .turn = 23,
                       .kind = wordOf(views),
                       .is_saved = hasNoPlace}),
      in(&View::azimuth_deg, {.key = "azimuth",
                              .option = "--azimuth",
                              .field = "azimuth_deg",
                              .heading = kViewHeading,
                              .turn = 24,
                              .kind = degrees,
                              .value = "DEGREES",
                              .help = "Turns the camera from the view about the up axis",
                              .is_saved = hasNoPlace}),
      in(&View::elevation_deg, {.key = "elevation",
                                .option = "--elevation",
                                .field = "elevation_deg",
                                .heading = kViewHeading,
                                .turn = 25,
                                .kind = degrees,
                                .value = "DEGREES",
                                .help = "Lifts the camera from the view",
                                .is_saved = hasNoPlace}),
      in(&View::fit,
         {.key = "fit",
          .option = "--fit",
          .is_rare = true,
          .turn = 26,
          .kind = wordOf({"visible", "volume"}),
          .help = "Fits the visible part into the picture, over all steps of a series unless "
                  "--this-step, or the volume's sphere (visible; with --view plain volume)",
          .is_saved = hasNoPlace}),
  };
}

}  // namespace sluice
