// The table of options: how values look.
#include "src/options/option_entries.h"

namespace sluice {
namespace {

using Look = LookOptions;
using Form = OptionForm;

// Points take the place of all other ways to give opacities, and a file that of a ramp and labels.
bool hasNoPoints(const ViewState& state) {
  return state.look.opacities.empty();
}
bool hasNoFile(const ViewState& state) {
  return hasNoPoints(state) && state.look.transfer_file.empty();
}
bool showsLabels(const ViewState& state) {
  return state.look.labels && hasNoFile(state);
}
bool hasRamp(const ViewState& state) {
  return hasNoFile(state) && !hasLabelsOfAnyKind(state);
}
// The opacity is for ramps and labels; modes that show values take it with a threshold alone.
bool hasOneOpacity(const ViewState& state) {
  return hasNoFile(state) &&
         (hasColors(state) || state.look.threshold || hasLabelsOfAnyKind(state));
}

}  // namespace

std::vector<OptionEntry> lookEntries() {
  const OptionKind light{.form = Form::kWord,
                         .words = {"chosen", "on", "off"},
                         .flags = {"", "--shade", "--no-shade"}};
  return {
      in(&Look::mode,
         {.key = "mode",
          .option = "--mode",
          .heading = kLookHeading,
          .turn = 12,
          .kind = wordOf({"composite", "mip", "minip", "average", "attenuated-mip", "depth-mip"}),
          .help = "How the samples along a ray are combined: composite, mip, minip, average, "
                  "attenuated-mip or depth-mip"}),
      in(&Look::attenuation, {.key = "attenuation",
                              .option = "--attenuation",
                              .heading = kLookHeading,
                              .is_rare = true,
                              .turn = 8,
                              .kind = {Form::kNumber, {0, 1000}},
                              .unset = 0.05,
                              .value = "A",
                              .help = "--mode attenuated-mip: a voxel length at the top of --range "
                                      "dims values behind it by "
                                      "exp(-A); lower values dim in proportion (0.05)",
                              .is_printed = isAttenuated}),
      in(&Look::light,
         {.key = "light", .option = "--shade", .turn = 7, .kind = light, .is_printed = hasColors}),
      in(&Look::threshold, {.key = "threshold",
                            .option = "--threshold",
                            .heading = kLookHeading,
                            .turn = 3,
                            .value = "VALUE",
                            .help = "Opacity 0 below this value, and a ramp above it",
                            .is_saved = hasRamp,
                            .is_printed = hasRamp}),
      in(&Look::opacity,
         {.key = "opacity",
          .option = "--opacity",
          .heading = kLookHeading,
          .turn = 4,
          .kind = {Form::kNumber, kShareRange},
          .value = "A",
          .help = "Opacity per voxel length at the top of a ramp (0.05), or of labels; automatic "
                  "opacities and those of --labels-table change in proportion to it",
          .is_saved = hasNoPoints,
          .is_printed = hasOneOpacity}),
      in(&Look::opacities,
         {.key = "opacities",
          .option = "--opacities",
          .heading = kLookHeading,
          .is_rare = true,
          .turn = 1,
          .kind = {Form::kPoints},
          .value = "V:A,V:A,...",
          .help =
              "Opacities per voxel length at these values, linear in between; with --transfer they "
              "replace the opacities of the file, whose colours stay"}),
      in(&Look::transfer_file, {.key = "transfer",
                                .option = "--transfer",
                                .field = "transfer_file",
                                .heading = kLookHeading,
                                .turn = 0,
                                .kind = {Form::kFile},
                                .value = "FILE",
                                .help = "Transfer function: our JSON or ParaView's colour map"}),
      in(&Look::labels, {.key = "labels",
                         .option = "--labels",
                         .heading = kPartsHeading,
                         .turn = 2,
                         .kind = {Form::kFlag},
                         .help = "Treats values as integer labels of a segmentation: each is "
                                 "opaque in its own colour, 0 is empty",
                         .is_saved = showsLabels,
                         .is_printed = hasNoFile}),
      in(&Look::label_table,
         {.key = "label_table",
          .option = "--labels-table",
          .heading = kPartsHeading,
          .is_rare = true,
          .turn = 2,
          .kind = {Form::kFile},
          .value = "FILE",
          .help = "Names, colours and opacities of labels, as ITK-SNAP, 3D Slicer or FreeSurfer "
                  "writes them; other labels do not show",
          .is_saved = hasNoFile,
          .is_printed = hasNoFile}),
      in(&Look::label_looks, {.key = "label_looks",
                              .option = "--label",
                              .heading = kPartsHeading,
                              .turn = 2,
                              .kind = {Form::kLabels},
                              .value = "N=COLOR[:A]",
                              .help = "Colour and opacity per voxel length of label N, of labels "
                                      "N-M or of all; may be given "
                                      "again",
                              .is_saved = hasNoFile,
                              .is_printed = hasNoFile}),
      in(&Look::map, {.key = "map", .option = "--map", .turn = 5, .kind = {Form::kText}}),
      in(&Look::range, {.key = "range",
                        .option = "--range",
                        .heading = kLookHeading,
                        .turn = 6,
                        .kind = {Form::kRange},
                        .value = "LO,HI",
                        .help = "Value range for colours, and the top of the ramp of --threshold "
                                "(the range of the data, over all steps of a series; colours of "
                                "--threshold begin there)"}),
      in(&Look::channels,
         {.key = "channels",
          .option = "--look",
          .heading = kPartsHeading,
          .turn = 10,
          .kind = {Form::kChannels},
          .value = "C:COLOR[,LO:HI[,A]]",
          .help =
              "The look of channel C: a colour, a map or 'labels', and the values over which its "
              "opacity rises from 0 to A; once for each channel; C is 'over' for the volume of "
              "--over "
              "(from the file, else automatic)"}),
      in(&Look::combine,
         {.key = "combine",
          .option = "--combine",
          .heading = kPartsHeading,
          .is_rare = true,
          .turn = 11,
          .kind = wordOf({"add", "blend"}),
          .help = "Adds the pictures of several channels, or blends all of them at each sample "
                  "(a volume of --over is blended if it has the grid of the first one; channels "
                  "are added)"}),
      in(&Look::surfaces,
         {.key = "surfaces",
          .option = "--iso",
          .heading = kPartsHeading,
          .turn = 8,
          .kind = {Form::kSurfaces},
          .value = "T[:A[:COLOR]],...",
          .help = "Draws lit surfaces at these values, with opacity A (1) and a colour (the "
                  "map's); the "
                  "volume is drawn, too, with --threshold, --transfer, --opacities or --opacity"}),
      in(&Look::full_gradient,
         {.key = "full_gradient",
          .option = "--full-gradient",
          .heading = kLightHeading,
          .is_rare = true,
          .turn = 8,
          .kind = {.limits = {0, 1e6, true}, .needs = "--modulate"},
          .value = "SHARE",
          .help = "Gradient magnitude at which the ramp of --modulate reaches 1, as a share of the "
                  "value range per voxel length",
          .is_printed = hasColors}),
  };
}

}  // namespace sluice
