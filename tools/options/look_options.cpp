#include <utility>

#include "src/classify/transfer/color_maps.h"
#include "src/library/conversions.h"
#include "tools/command_line/interrupt.h"
#include "tools/options/shared_options.h"

namespace sluice {

void addLookOptions(CLI::App& app, const AskedView& asked, LookArguments& look,
                    FrameOptions& frame) {
  look.stop = interruption();
  const OptionGroup group(app, std::string(kLookHeading)), light(app, std::string(kLightHeading));
  const TableOptions table(app, asked, [&look, &frame](const ViewState& state) {
    setLook(state.look, look);
    frame.mode = modeOf(state.look);
    if (!state.background) return;
    look.background = *state.background;
    look.has_background = true;
  });
  CLI::Option* threshold = table.add("-t,--threshold");
  CLI::Option* transfer = table.add("--transfer");
  CLI::Option* points = table.add("--opacities");
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
  table.add("--range");
  group.rare().flag("--this-step", look.this_step,
                    "Series: computes look and fit from the drawn step alone");
  CLI::Option* opacity = table.add("--opacity");
  table.addRest(kLookHeading, OptionPart::kLook);
  table.add("--background");
  table.addRest(kPartsHeading, OptionPart::kLook);
  CLI::Option* labels = app.get_option("--labels");
  for (CLI::Option* of_labels :
       {labels, app.get_option("--labels-table"), app.get_option("--label")})
    for (CLI::Option* other : {threshold, transfer, points, app.get_option("--iso")})
      other->excludes(of_labels);
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
  table.add("--full-gradient", numberText(look.full_gradient))->needs(modulate);
  table.addRest(kLightHeading, OptionPart::kLook);
}

}  // namespace sluice
