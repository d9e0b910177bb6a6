#include <utility>

#include "src/classify/transfer/color_maps.h"
#include "src/library/conversions.h"
#include "tools/command_line/interrupt.h"
#include "tools/options/shared_options.h"

namespace sluice {
void addLookOptions(CLI::App& app, const AskedView& asked, LookArguments& look,
                    FrameOptions& frame) {
  look.stop = interruption();
  constexpr const char* kParts = "Channels, labels, surfaces";
  const OptionGroup group(app, "Look"), parts(app, kParts), light(app, "Light");
  const TableOptions table(app, "Look", asked), parts_table(app, kParts, asked);
  CLI::Option* threshold = table.add(
      "-t,--threshold", [&look](const ViewState& state) { look.threshold = state.look.threshold; });
  CLI::Option* transfer = table.add("--transfer", [&look](const ViewState& state) {
    look.transfer_file = state.look.transfer_file;
  });
  CLI::Option* points = table.add("--opacities", [&look](const ViewState& state) {
    look.opacities.clear();
    for (const LookOptions::Opacity& point : state.look.opacities)
      look.opacities.push_back({point.value, point.opacity});
  });
  CLI::Option* labels = parts.flag("--labels", look.labels,
                                   "Treats values as integer labels of a segmentation: each is "
                                   "opaque in its own colour, 0 is empty");
  const auto takeLabels = [&look](const ViewState& state) {
    LookOptions of_labels;
    of_labels.label_table = state.look.label_table;
    of_labels.label_looks = state.look.label_looks;
    LookArguments taken = lookArguments(of_labels, true);
    look.labels = true;
    look.label_table = std::move(taken.label_table);
    look.label_looks = std::move(taken.label_looks);
  };
  CLI::Option* label_table = parts_table.add("--labels-table", takeLabels);
  CLI::Option* label_looks = parts_table.add("--label", takeLabels)->trigger_on_parse();
  Words<std::string> maps;
  for (const std::string_view name : colorMapNames()) maps.emplace_back(name, name);
  for (const std::string_view name : solidColorNames()) maps.emplace_back(name, name);
  // Options are taken in the order in which they are added: --transfer is known by now.
  const auto mapOfFile = [&look](const std::string& word) {
    const bool is_map = !look.transfer_file.empty() || hexColor(word);
    return is_map ? std::optional(word) : std::nullopt;
  };
  group.choice<std::string>("--map", maps, look.map,
                            "Changes the colours only: " + listed(namesOf(maps)) +
                                "; one colour as RRGGBB; or the name of a map in --transfer",
                            mapOfFile, "one colour as RRGGBB");
  table.add("--range", [&look](const ViewState& state) {
    look.range = {(*state.look.range)[0], (*state.look.range)[1]};
  });
  parts_table
      .add("--look",
           [&look](const ViewState& state) {
             LookOptions channels;
             channels.channels = state.look.channels;
             look.channels = lookArguments(channels, true).channels;
           })
      ->trigger_on_parse();
  parts_table.add("--combine", [&look](const ViewState& state) {
    LookOptions combined;
    combined.combine = state.look.combine;
    look.combine = lookArguments(combined, true).combine;
  });
  CLI::Option* surfaces = parts_table.add("--iso", [&look](const ViewState& state) {
    LookOptions of_surfaces;
    of_surfaces.surfaces = state.look.surfaces;
    look.surfaces = lookArguments(of_surfaces, true).surfaces;
  });
  for (CLI::Option* of_labels : {labels, label_table, label_looks})
    for (CLI::Option* other : {threshold, transfer, points, surfaces}) other->excludes(of_labels);
  group.rare().flag("--this-step", look.this_step,
                    "Series: computes look and fit from the drawn step alone");
  CLI::Option* opacity = table.add(
      "--opacity", [&look](const ViewState& state) { look.opacity = state.look.opacity; });
  // Points given with a file replace its own; its colours stay.
  const auto goTogether = [&](const CLI::Option* one, const CLI::Option* other) {
    return (one == transfer && other == points) || (one == points && other == transfer);
  };
  for (CLI::Option* one : {threshold, transfer, points, labels})
    for (CLI::Option* other : {threshold, transfer, points, labels})
      if (one != other && !goTogether(one, other)) one->excludes(other);
  points->excludes(opacity);
  CLI::Option* shade = light.flag("--shade", look.shade, "Gradient Phong lighting");
  light
      .flag("--no-shade", look.no_shade,
            "No lighting; without this option, pictures that show surfaces are lit")
      ->excludes(shade);
  CLI::Option* modulate = light.rare().flag(
      "--modulate", look.modulate,
      "Multiplies the opacity by a ramp of the gradient's magnitude, 0 where the volume is flat");
  TableOptions(app, "Light", asked)
      .add(
          "--full-gradient",
          [&look](const ViewState& state) { look.full_gradient = *state.look.full_gradient; },
          numberText(look.full_gradient))
      ->needs(modulate);
  table.add("--mode", [&frame](const ViewState& state) { frame.mode = modeOf(state.look); });
  table.add("--attenuation",
            [&look](const ViewState& state) { look.attenuation = *state.look.attenuation; });
  table.add("--background", [&look](const ViewState& state) {
    look.background = *state.background;
    look.has_background = true;
  });
}

}  // namespace sluice
