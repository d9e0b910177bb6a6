#include "io/hdf5/hdf5_axes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "io/files/length_unit.h"
#include "io/hdf5/hdf5_input.h"
#include "io/headers/volume_description.h"
#include "src/base/error.h"
#include "src/base/files/json_field.h"
#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

constexpr size_t kSpaceAxes = 3;

double oneNumber(const std::vector<Hdf5Attribute>& attributes, const char* key, double otherwise) {
  const Hdf5Attribute* const found = find(attributes, key);
  return found != nullptr && found->numbers.size() == 1 ? found->numbers[0] : otherwise;
}

std::string oneText(const std::vector<Hdf5Attribute>& attributes, const char* key) {
  const Hdf5Attribute* const found = find(attributes, key);
  return found != nullptr && found->texts.size() == 1 ? found->texts[0] : std::string();
}

// CF: a time has units such as "hours since 1900-01-01".
ZarrAxis axisOf(const Hdf5Scale& scale) {
  ZarrAxis axis;
  axis.name = scale.path.substr(scale.path.rfind('/') + 1);
  const std::string role = lowercase(oneText(scale.attributes, "axis"));
  if (role == "x" || role == "y" || role == "z") axis.name = role;
  if (role == "t" || oneText(scale.attributes, "units").find(" since ") != std::string::npos)
    axis.type = "time";
  return axis;
}

bool isSpace(const ZarrAxis& axis) {
  const std::string name = lowercase(axis.name);
  return axis.type.empty() && name != "t" && name != "time" && name != "c" && name != "channel";
}

// Whether names tell x, y and z: three axes of space at most.
bool areUsable(const std::vector<ZarrAxis>& axes) {
  std::vector<std::string> known;
  const auto space = std::ranges::count_if(axes, isSpace);
  for (const ZarrAxis& axis : axes) {
    const std::string name = lowercase(axis.name);
    if (!isSpace(axis) || (name != "x" && name != "y" && name != "z")) continue;
    if (std::ranges::find(known, name) != known.end()) return false;
    known.push_back(name);
  }
  return space == kSpaceAxes && axes.size() - kSpaceAxes <= 2;
}

// Names of the axes; empty: none.
std::vector<ZarrAxis> axesOf(const Hdf5Description& description, const std::string& name) {
  std::vector<ZarrAxis> axes;
  const size_t count = description.shape.size();
  if (const Hdf5Attribute* tags = find(description.attributes, "axistags");
      tags && tags->texts.size() == 1) {
    const nlohmann::json document = parseJson(tags->texts[0], name + ": axistags");
    const JsonField list = JsonField(document, name + ": axistags").require("axes");
    if (list.size() != count) list.failExpected(fmt::format("{} axes", count));
    for (size_t i = 0; i < list.size(); ++i)
      axes.push_back({list[i].require("key").text(), "", ""});
    return axes;
  }
  if (const Hdf5Attribute* labels = find(description.attributes, "DIMENSION_LABELS");
      labels && labels->texts.size() == count)
    for (const std::string& label : labels->texts) axes.push_back({label, "", ""});
  if (axes.empty())
    for (const Hdf5Scale& scale : description.scales) axes.push_back(axisOf(scale));
  if (std::ranges::any_of(axes, [](const ZarrAxis& axis) { return axis.name.empty(); }) ||
      (!description.scales.empty() && !areUsable(axes)))
    axes.clear();
  return axes;
}

// The axes that viewZarr() takes for an array without names.
std::vector<ZarrAxis> unnamed(size_t axes, bool channel_wanted) {
  std::vector<ZarrAxis> list;
  for (const char letter : std::string_view(channel_wanted && axes == 4 ? "czyx" : "tczyx"))
    list.push_back({std::string(1, letter), "", ""});
  if (axes == 4 && !channel_wanted) list.erase(list.begin() + 1);
  list.erase(list.begin(), list.end() - static_cast<std::ptrdiff_t>(std::min(axes, list.size())));
  return list;
}

// Degrees to the north are as wide as those to the east.
std::string unitOf(const Hdf5Scale& scale) {
  const std::string unit = oneText(scale.attributes, "units");
  if (unit.starts_with("degree")) return "degree";
  return unit == "1" ? "" : lengthUnit(unit);
}

// The positions along an axis as a first one and a step.
struct Steps {
  double first = 0, step = 1;
  std::string note;  // for people; empty: the positions are these
};
Steps stepsOf(const Hdf5Scale& scale) {
  const double factor = oneNumber(scale.attributes, "scale_factor", 1);
  const double offset = oneNumber(scale.attributes, "add_offset", 0);
  std::vector<double> at = scale.values;
  double most = 0;
  for (double& value : at) {
    value = value * factor + offset;
    most = std::max(most, std::abs(value));
  }
  if (!std::ranges::all_of(at, [](double value) { return std::isfinite(value); }))
    return {0, 1, "are not all numbers; its voxels are drawn 1 apart"};
  if (at.size() < 2) return {at.empty() ? 0 : at[0], 1, ""};
  Steps steps{at[0], (at.back() - at[0]) / static_cast<double>(at.size() - 1), ""};
  double least = std::numeric_limits<double>::infinity(), widest = 0;
  for (size_t i = 1; i < at.size(); ++i) {
    const double step = (at[i] - at[i - 1]) / steps.step;
    least = std::min(least, step);
    widest = std::max(widest, step);
  }
  if (!(least > 0))
    return {at[0], 1, "neither increase nor decrease throughout; its voxels are drawn 1 apart"};
  // Positions are often rounded to floats.
  const double slack =
      0.01 * std::abs(steps.step) + 2 * double{std::numeric_limits<float>::epsilon()} * most;
  for (size_t i = 0; i < at.size(); ++i)
    if (std::abs(at[i] - steps.first - static_cast<double>(i) * steps.step) > slack) {
      const double size = std::abs(steps.step);
      steps.note = fmt::format("are {:g} to {:g} apart; its voxels are drawn evenly, {:g} apart",
                               least * size, widest * size, size);
      break;
    }
  return steps;
}

// Spacing and origin from the scales.
void placeByScales(const Hdf5Description& description, const std::string& name, Hdf5Image& found) {
  ZarrImage& image = found.image;
  const size_t added = image.axes.size() - description.shape.size();
  std::vector<size_t> placed;
  std::vector<std::string> units;
  const auto isLength = [](const std::string& unit) { return metersOf(unit).has_value(); };
  const auto addPlaced = [&](bool is_long) {
    for (size_t i = 0; i < description.scales.size(); ++i) {
      const Hdf5Scale& scale = description.scales[i];
      if (!isSpace(image.axes[added + i]) || scale.values.empty() ||
          (scale.values.size() > 1) != is_long)
        continue;
      const std::string unit = unitOf(scale);
      // A single layer may have any height, such as 2 m above degrees.
      const bool fits = is_long || units.empty() || unit == units.front() ||
                        (isLength(unit) && isLength(units.front()));
      if (!fits) continue;
      placed.push_back(i);
      units.push_back(unit);
    }
  };
  addPlaced(true);
  addPlaced(false);
  if (placed.empty()) return;
  if (std::ranges::adjacent_find(units, std::not_equal_to<>()) != units.end() &&
      !std::ranges::all_of(units, isLength)) {
    for (std::string& unit : units)
      if (unit.empty()) unit = "none";
    found.notes.push_back(
        fmt::format("{}: the coordinates of its axes have different units ({}); its voxels are "
                    "drawn 1 apart, unless you give --spacing",
                    name, fmt::join(units, ", ")));
    return;
  }
  image.scale.assign(image.axes.size(), 1);
  image.translation.assign(image.axes.size(), 0);
  for (size_t i = 0; i < placed.size(); ++i) {
    const Hdf5Scale& scale = description.scales[placed[i]];
    const Steps steps = stepsOf(scale);
    image.scale[added + placed[i]] = steps.step;
    image.translation[added + placed[i]] = steps.first;
    image.axes[added + placed[i]].unit = units[i];
    if (!steps.note.empty())
      found.notes.push_back(fmt::format("{}: the coordinates of its axis {} {}", name,
                                        printable(scale.path, 200), steps.note));
  }
  for (size_t a = added; a < image.axes.size(); ++a)
    if (isSpace(image.axes[a]) && description.scales[a - added].values.empty() &&
        description.shape[a - added] > 1) {
      image.axes[a].unit = units.front();
      found.notes.push_back(
          fmt::format("{}: its axis {} has no coordinates; its voxels are drawn 1 apart along it",
                      name, printable(image.axes[a].name, 200)));
    }
}

void placeByElementSize(const Hdf5Attribute& size, ZarrImage& image) {
  const size_t axes = image.axes.size();
  image.scale.assign(axes, 1);
  image.translation.assign(axes, 0);
  constexpr std::string_view kNames[] = {"z", "y", "x"};
  for (size_t a = 0; a < kSpaceAxes; ++a) {
    size_t at = axes - kSpaceAxes + a;
    for (size_t i = 0; i < axes; ++i)
      if (image.axes[i].name == kNames[a]) at = i;
    image.scale[at] = size.numbers[a];
    image.axes[at].unit = "micrometer";
  }
  image.frame = WorldFrame::kPictureRows;
}

}  // namespace

Hdf5Image hdf5ImageOf(const Hdf5Description& description, size_t axes, bool channel_wanted,
                      const std::string& name) {
  Hdf5Image found;
  ZarrImage& image = found.image;
  image.axes = axesOf(description, name);
  if (image.axes.size() != axes) image.axes = unnamed(axes, channel_wanted);
  if (const Hdf5Attribute* const size = find(description.attributes, "element_size_um");
      size != nullptr && size->numbers.size() == kSpaceAxes) {
    placeByElementSize(*size, image);
    if (std::string note = negativeSpacingNote(name, size->numbers); !note.empty())
      found.notes.push_back(std::move(note));
  } else {
    placeByScales(description, name, found);
  }
  image.value_scale = oneNumber(description.attributes, "scale_factor", 1);
  image.value_offset = oneNumber(description.attributes, "add_offset", 0);
  found.is_unsigned = oneText(description.attributes, "_Unsigned") == "true";
  for (const char* key : {"_FillValue", "missing_value"})
    if (const Hdf5Attribute* const numbers = find(description.attributes, key))
      image.missing.insert(image.missing.end(), numbers->numbers.begin(), numbers->numbers.end());
  const auto limit = [&](const char* name, size_t of_range) -> std::optional<double> {
    if (const Hdf5Attribute* const range = find(description.attributes, "valid_range");
        range != nullptr && range->numbers.size() == 2)
      return range->numbers[of_range];
    const Hdf5Attribute* const one = find(description.attributes, name);
    return one != nullptr && one->numbers.size() == 1 ? std::optional(one->numbers[0])
                                                      : std::nullopt;
  };
  image.valid_least = limit("valid_min", 0);
  image.valid_greatest = limit("valid_max", 1);
  if (!found.is_unsigned) return found;
  const auto makeUnsigned = [&](double& number) {
    if (number < 0) number += std::ldexp(1, 8 * static_cast<int>(bytesPerVoxel(description.type)));
  };
  for (double& number : image.missing) makeUnsigned(number);
  for (std::optional<double>* number : {&image.valid_least, &image.valid_greatest})
    if (*number) makeUnsigned(**number);
  return found;
}

}  // namespace sluice
