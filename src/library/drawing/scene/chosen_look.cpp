#include "src/library/drawing/scene/chosen_look.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "src/base/error.h"
#include "src/base/files/shell_word.h"
#include "src/base/values/tidy_number.h"
#include "src/classify/transfer/automatic_look.h"
#include "src/classify/transfer/color_maps.h"
#include "src/classify/transfer/label_table.h"
#include "src/classify/transfer/transfer_file.h"
#include "src/classify/transfer/transfer_makers.h"
#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

// The map of modes that use values alone: grey, as radiologists use it.
constexpr std::string_view kModeMap = "grey";
// The map of depths.
constexpr std::string_view kDepthMap = "turbo";

std::string_view mapOr(const LookArguments& look, std::string_view otherwise) {
  return look.map.empty() ? otherwise : std::string_view(look.map);
}

// Such a range is printed as an option. It is drawn as it is printed, so that the option gives the
// look again.
ValueRange tidyRange(ValueRange range) {
  // Values far off 0 may differ in the digits that tidyNumber() leaves out.
  const double most = 1e-6 * (range.hi - range.lo);
  const auto tidy = [most](double value) {
    const double number = tidyNumber(value);
    return std::abs(number - value) <= most ? number : value;
  };
  return {tidy(range.lo), tidy(range.hi)};
}

ValueRange ascending(ValueRange range) {
  return {std::min(range.lo, range.hi), std::max(range.lo, range.hi)};
}

// Nothing for a volume of a single value, whose range follows from it: --range takes two values.
std::string rangeOption(ValueRange range) {
  if (range.lo == range.hi) return {};
  return fmt::format(" --range {},{}", range.lo, range.hi);
}

std::string pointsOption(const std::vector<OpacityPoint>& points) {
  std::string text = " --opacities ";
  for (size_t i = 0; i < points.size(); ++i)
    text += fmt::format("{}{}:{}", i == 0 ? "" : ",", points[i].value, points[i].opacity);
  return text;
}

AutomaticOptions automaticOptions(const VolumeLayout& layout, const LookArguments& look) {
  AutomaticOptions options;
  options.finest_spacing = finestSpacing(layout);
  options.thickness_vox = 0;
  for (int a = 0; a < 3; ++a)
    options.thickness_vox +=
        static_cast<double>(layout.dims[a]) * layout.spacing[a] / options.finest_spacing / 3;
  options.signed_distance = layout.name.ends_with("(level set)");
  options.map = look.map;
  return options;
}

class Chooser {
 public:
  Chooser(const VolumeLayout& layout, const ValueStatistics& values, const LookArguments& look,
          Mode mode)
      : layout_(layout),
        values_(values),
        look_(look),
        mode_(mode),
        map_range_(look.range.value_or(tidyRange(values.range))),
        range_(ascending(map_range_)) {}

  ChosenLook choose() {
    // Explicit wishes decide before the defaults of the mode.
    chosen_.mode = mode_;
    chosen_.lit = look_.first_picture;
    if (drawsSurfacesAlone()) {
      onlyColors();
    } else if (!look_.transfer_file.empty()) {
      fromFile();
    } else if (!look_.opacities.empty()) {
      fromPoints();
    } else if (look_.labels) {
      fromLabels();
    } else if (look_.threshold) {
      fromThreshold(*look_.threshold);
    } else if (!traitsOf(mode_).has_colors) {
      wholeRange();
    } else if (!look_.first_picture) {
      fromThreshold(plainThreshold(range_));
    } else {
      automatic();
    }
    // light() comes last, since it overrides the light that surfaces ask for and takes the leading
    // blank off all options.
    fadeSolidColor();
    addSurfaces();
    modulate();
    attenuate();
    light();
    return std::move(chosen_);
  }

 private:
  void add(const std::string& option) { chosen_.unlit_options += option; }
  void addMap(std::string_view map) { add(fmt::format(" --map {}", shellWord(std::string(map)))); }
  void addRange(ValueRange range) {
    add(rangeOption(range));
    if (range.lo != range.hi) said_range_ = ascending(range);
  }

  // The mode's map, whichever values show.
  std::string_view usualMap() const {
    if (traitsOf(mode_).has_colors) return kDefaultColorMap;
    return traitsOf(mode_).codes_depth ? kDepthMap : kModeMap;
  }

  void fromFile() {
    chosen_.transfer = readTransferFunction(look_.transfer_file, range_, look_.map, look_.stop);
    add(fmt::format(" --transfer {}", shellWord(look_.transfer_file)));
    if (!look_.map.empty()) addMap(look_.map);
    if (look_.range) measureFlatness(range_);
    if (look_.range) addRange(*look_.range);
    if (look_.opacity)
      chosen_.warnings.push_back(fmt::format(
          "--opacity {}: changes nothing, since --transfer has opacities of its own; --opacities "
          "replaces them",
          *look_.opacity));
    if (look_.opacities.empty()) return;
    chosen_.transfer.opacities = look_.opacities;  // over the file's colours
    add(pointsOption(look_.opacities));
  }

  void fromPoints() {
    const std::string_view map = mapOr(look_, usualMap());
    chosen_.transfer = pointsTransfer(map, map_range_, look_.opacities);
    measureFlatness(map_range_);
    addMap(map);
    addRange(map_range_);
    add(pointsOption(look_.opacities));
  }

  void fromLabels() {
    std::vector<LabelStyle> styles = labelStylesOf(values_.counts, look_.map);
    if (!look_.label_table.empty()) {
      const std::vector<LabelStyle> table = readLabelTable(look_.label_table, look_.stop);
      if (const std::string fault = faultOfTable(table, styles, values_.counts); !fault.empty())
        chosen_.warnings.push_back(fmt::format("--labels-table {}: {}", look_.label_table, fault));
      applyTable(styles, table);
    }
    chosen_.label_opacity = look_.opacity.value_or(1);
    scaleOpacities(styles, chosen_.label_opacity);
    applyLooks(styles, look_.label_looks);
    chosen_.transfer = labelsTransfer(styles);
    if (const size_t close = labelsTooClose(styles); close > 0)
      chosen_.warnings.push_back(fmt::format(
          "labels from {:.17g} to {:.17g}: {} of them may show as another label or not at all, "
          "since numbers that span more than {} share looks with close ones; number them anew",
          styles.front().label, styles.back().label, close, kMostLabelEntries));
    for (const LabelStyle& style : styles)
      if (!style.name.empty()) chosen_.label_names.emplace(style.label, style.name);
    addLabels();
    if (look_.opacity) add(fmt::format(" --opacity {}", *look_.opacity));
    if (!look_.label_table.empty()) add(" --labels-table " + shellWord(look_.label_table));
    for (const LabelLook& look : look_.label_looks) {
      if (hasLabelOf(look))
        add(" --label " + shellWord(labelLookText(look)));
      else
        chosen_.warnings.push_back(
            fmt::format("--label {}: no voxel has {}", labelLookText(look),
                        look.first == look.last ? "this label" : "one of these labels"));
    }
  }
  // Also if the values are not known.
  bool hasLabelOf(const LabelLook& look) const {
    const std::vector<ValueCount>& entries = values_.counts.entries;
    return entries.empty() || std::ranges::any_of(entries, [&](const ValueCount& entry) {
             return entry.lo <= look.last && entry.hi >= look.first;
           });
  }
  void addLabels() {
    add(" --labels");
    if (!look_.map.empty()) addMap(look_.map);
  }

  void fromThreshold(double threshold) {
    const std::string_view map = mapOr(look_, usualMap());
    const double opacity = look_.opacity.value_or(kDefaultOpacity);
    chosen_.transfer = thresholdTransfer(threshold, range_, opacity, map);
    // The colours begin at the threshold, unless the user says where.
    if (look_.range)
      chosen_.transfer.colors = pointsTransfer(map, map_range_, chosen_.transfer.opacities).colors;
    add(fmt::format(" --threshold {} --opacity {}", threshold, opacity));
    addMap(map);
    if (look_.range) measureFlatness(range_);
    if (look_.range) addRange(*look_.range);
    const ValueRange all = values_.range;
    if (!values_.counts.entries.empty() && (threshold > all.hi || threshold < all.lo))
      chosen_.warnings.push_back(
          fmt::format("--threshold {}: {} shows, the values are {:.6g} to {:.6g}", threshold,
                      threshold > all.hi ? "nothing" : "everything", all.lo, all.hi));
  }

  void wholeRange() {
    const std::string_view map = mapOr(look_, usualMap());
    chosen_.transfer = wholeRangeTransfer(map, map_range_);
    addMap(map);
    addRange(map_range_);
    if (look_.opacity)
      chosen_.warnings.push_back(fmt::format(
          "--opacity {}: changes nothing in this --mode without --threshold", *look_.opacity));
  }

  void automatic() {
    const ValueCounts counts = look_.range ? inside(values_.counts, range_) : values_.counts;
    AutomaticLook made = automaticLook(counts, automaticOptions(layout_, look_));
    chosen_.transfer = std::move(made.transfer);
    chosen_.lit = chosen_.lit && made.lit;
    if (chosen_.transfer.labels) {
      fromLabels();
      return;
    }
    if (look_.range) {
      TransferFunction over_range =
          pointsTransfer(made.map, map_range_, std::move(chosen_.transfer.opacities));
      over_range.name = std::move(chosen_.transfer.name);
      chosen_.transfer = std::move(over_range);
      made.map_range = map_range_;
    }
    if (look_.opacity)
      chosen_.transfer =
          scaleOpacity(std::move(chosen_.transfer), *look_.opacity / kDefaultOpacity);
    measureFlatness(made.map_range);
    addMap(made.map);
    addRange(made.map_range);
    add(pointsOption(chosen_.transfer.opacities));
  }

  bool drawsSurfaces() const { return !look_.surfaces.empty() && traitsOf(mode_).has_colors; }
  // Nothing asks for opacities.
  bool drawsSurfacesAlone() const {
    return drawsSurfaces() && look_.transfer_file.empty() && look_.opacities.empty() &&
           !look_.labels && !look_.threshold && !look_.opacity;
  }

  // The colours of the automatic look, and no opacities.
  void onlyColors() {
    std::string map(mapOr(look_, kDefaultColorMap));
    ValueRange range = map_range_;
    if (look_.first_picture && look_.map.empty()) {
      const AutomaticLook made = automaticLook(values_.counts, automaticOptions(layout_, look_));
      if (!made.transfer.labels) map = made.map;
      if (!made.transfer.labels && !look_.range) range = made.map_range;
      // The greatest value has the brightest colour of the map.
      double top = range.lo;
      for (const SurfaceLook& surface : look_.surfaces) top = std::max(top, surface.value);
      if (!look_.range && top > range.lo) range.hi = top;
    }
    chosen_.transfer = pointsTransfer(map, range, {{range_.lo, 0}});
    addMap(map);
    addRange(range);
  }

  Vec3d colorOf(const SurfaceLook& surface) const {
    if (surface.color.empty()) return colorAt(chosen_.transfer, surface.value);
    if (const auto rgb = solidColor(surface.color)) return *rgb;
    failRequest("--iso {}: there is no colour {}; give RRGGBB or one of {}",
                surfaceLookText(surface), surface.color, fmt::join(solidColorNames(), ", "));
  }

  void addSurfaces() {
    if (!drawsSurfaces()) return;
    if (chosen_.transfer.labels)
      failRequest(
          "--iso draws surfaces between values, which labels do not have; leave out --labels");
    std::string text;
    for (const SurfaceLook& look : look_.surfaces) {
      chosen_.transfer.surfaces.push_back({look.value, look.opacity, colorOf(look)});
      text += (text.empty() ? "" : ",") + surfaceLookText(look);
      // A range of one value may also mean that nothing is known.
      const bool is_known = values_.range.lo < values_.range.hi;
      if (is_known && !(look.value >= values_.range.lo && look.value <= values_.range.hi))
        chosen_.warnings.push_back(
            fmt::format("--iso {}: no surface, the values are {:.6g} to {:.6g}", look.value,
                        values_.range.lo, values_.range.hi));
    }
    add(" --iso " + shellWord(text));
    chosen_.lit = look_.first_picture;
  }

  // By the colours alone, so that options that determine them give the same light again, whatever
  // is known of the values: in a series, the range of one step or of all.
  void measureFlatness(ValueRange colors) {
    const double part = std::abs(colors.hi - colors.lo), all = values_.range.hi - values_.range.lo;
    if (all > 0) chosen_.flat_scale = part / all;
  }

  // Modes that show one value a pixel, opaque, tell values apart by the colour alone: from black up
  // to it.
  void fadeSolidColor() {
    if (!traitsOf(mode_).has_colors && !chosen_.transfer.labels && solidColor(look_.map))
      chosen_.transfer.colors.front().rgb = {0, 0, 0};
  }

  void modulate() {
    if (!look_.modulate || !traitsOf(mode_).has_colors) return;
    // A volume of one value is flat, whatever the unit.
    const double unit = range_.hi > range_.lo ? range_.hi - range_.lo : 1;
    // Labels have no use for the range, but the gradients are a share of it.
    if (look_.range && !said_range_) addRange(*look_.range);
    // A share of the range that the options say, which may be another one.
    const double said = said_range_ ? said_range_->hi - said_range_->lo : unit;
    const double share =
        said == unit ? look_.full_gradient : tidyNumber(look_.full_gradient * unit / said);
    chosen_.transfer = modulateByGradient(std::move(chosen_.transfer), share * said);
    add(fmt::format(" --modulate --full-gradient {}", share));
  }

  void attenuate() {
    if (traitsOf(mode_).combining != Combining::kAttenuated) return;
    chosen_.transfer.attenuation = look_.attenuation;
    add(fmt::format(" --attenuation {}", look_.attenuation));
  }

  void light() {
    if (!traitsOf(mode_).has_colors || look_.no_shade) chosen_.lit = false;
    if (look_.shade && traitsOf(mode_).has_colors) chosen_.lit = true;
    if (!chosen_.unlit_options.empty()) chosen_.unlit_options.erase(0, 1);
  }

  const VolumeLayout& layout_;
  const ValueStatistics& values_;
  const LookArguments& look_;
  const Mode mode_;
  const ValueRange map_range_, range_;    // the range as given, and ascending
  std::optional<ValueRange> said_range_;  // that of the options, ascending
  ChosenLook chosen_;
};

}  // namespace

std::string ChosenLook::lightOption() const {
  if (!traitsOf(mode).has_colors) return {};
  return lit ? "--shade" : "--no-shade";
}

std::string ChosenLook::options() const {
  const std::string light = lightOption();
  return unlit_options + (unlit_options.empty() || light.empty() ? "" : " ") + light;
}

ChosenLook chooseLook(const VolumeLayout& layout, const ValueStatistics& values,
                      const LookArguments& look, Mode mode) {
  return Chooser(layout, values, look, mode).choose();
}

double plainThreshold(ValueRange range) {
  return std::lerp(range.lo, range.hi, 0.2);
}

bool needsGradients(const LookArguments& look, Mode mode) {
  if (!look.surfaces.empty() && traitsOf(mode).has_colors) return true;
  if (look.shade || look.modulate) return true;
  if (look.first_picture && !look.no_shade && traitsOf(mode).has_colors) return true;
  // Whatever the volume's range is.
  return !look.transfer_file.empty() &&
         !readTransferFunction(look.transfer_file, {0, 1}, look.map, look.stop).gradients.empty();
}

bool needsStatistics(const LookArguments& look) {
  const bool stands_alone =
      look.threshold || !look.opacities.empty() || !look.transfer_file.empty();
  return !(look.range && stands_alone) || look.labels;
}

}  // namespace sluice
