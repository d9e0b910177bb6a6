#include <algorithm>

#include "src/classify/transfer/color_maps.h"
#include "tools/command_line/interrupt.h"
#include "tools/command_line/parse.h"
#include "tools/options/shared_options.h"

namespace sluice {
namespace {

// "40:0,60:0.1".
std::optional<std::vector<OpacityPoint>> opacityPoints(const std::string& word) {
  std::vector<OpacityPoint> points;
  for (size_t from = 0; from <= word.size();) {
    const size_t end = std::min(word.find(',', from), word.size());
    std::string pair = word.substr(from, end - from);
    const size_t colon = pair.find(':');
    if (colon == std::string::npos) return std::nullopt;
    pair[colon] = ',';
    const auto numbers = parseNumbers(pair, 2);
    if (!numbers || (*numbers)[1] < 0 || (*numbers)[1] > 1) return std::nullopt;
    if (!points.empty() && (*numbers)[0] < points.back().value) return std::nullopt;
    points.push_back({(*numbers)[0], (*numbers)[1]});
    from = end + 1;
  }
  return points;
}

std::optional<ValueRange> valueRange(const std::string& word) {
  const auto numbers = parseNumbers(word, 2);
  const bool is_size = word.find('x') != std::string::npos;  // "0x10" is no range
  if (!numbers || is_size || (*numbers)[0] == (*numbers)[1]) return std::nullopt;
  return ValueRange{(*numbers)[0], (*numbers)[1]};
}

}  // namespace

void addLookOptions(CLI::App& app, LookArguments& look, FrameOptions& frame) {
  look.stop = interruption();
  const OptionGroup group(app, "Look"), light(app, "Light");
  CLI::Option* threshold = group.number("-t,--threshold", "VALUE", look.threshold, {},
                                        "Opacity 0 below this value, and a ramp above it");
  CLI::Option* transfer = group.text("--transfer", "FILE", look.transfer_file,
                                     "Transfer function: our JSON or ParaView's colour map");
  CLI::Option* points = group.parsed(
      "--opacities", "V:A,V:A,...", "pairs V:A of values, ascending, and opacities from 0 to 1",
      opacityPoints, [&look](const std::vector<OpacityPoint>& found) { look.opacities = found; },
      "Opacities per voxel length at these values, linear in between; with --transfer they replace "
      "the opacities of the file, whose colours stay");
  CLI::Option* labels = group.flag("--labels", look.labels,
                                   "Treats values as integer labels of a segmentation: each is "
                                   "opaque in its own colour, 0 is empty");
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
                            mapOfFile);
  group.parsed(
      "--range", "LO,HI", "two different numbers LO,HI", valueRange,
      [&look](ValueRange range) { look.range = range; },
      "Value range for colours and ramps (the range of the data, over all steps of a series)");
  group.flag("--this-step", look.this_step,
             "Series: computes look and fit from the drawn step alone");
  CLI::Option* opacity = group.number("--opacity", "A", look.opacity, {0, 1},
                                      "Opacity per voxel length at the top of the ramp (0.05)");
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
  CLI::Option* modulate = light.flag(
      "--modulate", look.modulate,
      "Multiplies the opacity by a ramp of the gradient's magnitude, 0 where the volume is flat");
  light
      .number("--full-gradient", "SHARE", look.full_gradient, {0, 1e6, true},
              "Gradient magnitude at which the ramp of --modulate reaches 1, as a share of the "
              "value range per voxel length")
      ->needs(modulate);
  group.choice("--mode",
               Words<Mode>{{"composite", Mode::kComposite},
                           {"mip", Mode::kMip},
                           {"minip", Mode::kMinip},
                           {"average", Mode::kAverage}},
               frame.mode, "How the samples along a ray are combined");
  group.parsed(
      "--background", "RRGGBB", "six hexadecimal digits RRGGBB", parseColor,
      [&look](const std::array<float, 3>& color) {
        look.background = color;
        look.has_background = true;
      },
      "Background colour; without it, PNG keeps alpha");
}

}  // namespace sluice
