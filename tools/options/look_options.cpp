#include <utility>

#include "src/base/looks/color_word.h"
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
  });
  table.add("-t,--threshold");
  table.add("--transfer");
  table.add("--opacities");
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
  table.add("--opacity");
  table.addRest(kLookHeading, OptionPart::kLook);
  table.add("--background");
  table.addRest(kPartsHeading, OptionPart::kLook);
  light.flag("--shade", look.shade, "Lights the picture (Phong lighting by the gradient)");
  light.flag(
      "--no-shade", look.no_shade,
      "No lighting; without this option, pictures of --mode composite are lit, except several "
      "channels, and a solid or translucent block that sluice chooses");
  light.rare().flag(
      "--modulate", look.modulate,
      "Multiplies the opacity by a ramp of the gradient's magnitude, 0 where the volume is flat");
  table.add("--full-gradient", numberText(look.full_gradient));
  table.addRest(kLightHeading, OptionPart::kLook);
}

}  // namespace sluice
