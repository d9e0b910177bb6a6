#include "io/zarr/metadata/omero_channels.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string_view>

#include "src/base/files/json_field.h"
#include "src/base/looks/color_word.h"

namespace sluice {
namespace {

// A text of six hexadecimal digits.
std::optional<std::array<double, 3>> colorOf(const JsonField& field) {
  if (!field.isText()) return std::nullopt;
  const std::optional<Vec3d> rgb = hexColor(field.text());
  if (!rgb) return std::nullopt;
  return std::array{rgb->x, rgb->y, rgb->z};
}

// Two numbers of an object, of which the second one is larger.
std::optional<ValueRange> rangeIn(const JsonField& field, const char* lower, const char* upper) {
  if (!field.isObject()) return std::nullopt;
  const auto lo = field.find(lower), hi = field.find(upper);
  if (!lo || !hi || !lo->isNumber() || !hi->isNumber()) return std::nullopt;
  const ValueRange range{lo->number(), hi->number()};
  return range.lo < range.hi ? std::optional(range) : std::nullopt;
}

// The part of a window that is shown.
std::optional<ValueRange> windowOf(const JsonField& field) {
  return rangeIn(field, "start", "end");
}

// Whether a window has an end, but no two numbers of a range.
bool saysRange(const JsonField& field) {
  if (!field.isObject()) return !field.isNull();
  return (field.find("start") || field.find("end")) && !windowOf(field);
}

// Lines about a file of many channels.
constexpr size_t kMostFaults = 8;

}  // namespace

std::vector<std::string> omeroNames(const JsonField& omero) {
  std::vector<std::string> names;
  const auto channels = omero.isObject() ? omero.find("channels") : std::nullopt;
  if (!channels || !channels->isArray()) return names;
  const size_t count = channels->size();
  for (size_t i = 0; i < count; ++i) {
    const JsonField channel = (*channels)[i];
    const auto label = channel.isObject() ? channel.find("label") : std::nullopt;
    names.push_back(label && label->isText() ? printable(label->text(), kLongestName) : "");
  }
  return names;
}

// Viewers leave out what they do not use, and so do we: a channel with a damaged colour has none.
std::vector<StoredLook> omeroLooks(const JsonField& omero) {
  std::vector<StoredLook> looks;
  const auto channels = omero.isObject() ? omero.find("channels") : std::nullopt;
  if (!channels || !channels->isArray()) return looks;
  bool says_something = false;
  for (size_t i = 0; i < channels->size(); ++i) {
    const JsonField channel = (*channels)[i];
    StoredLook& look = looks.emplace_back();
    if (!channel.isObject()) continue;
    if (const auto color = channel.find("color")) look.color = colorOf(*color);
    if (const auto window = channel.find("window")) {
      look.window = windowOf(*window);
      // The numbers between which viewers let users choose it.
      look.limits = rangeIn(*window, "min", "max");
    }
    if (const auto active = channel.find("active"); active && active->isFlag())
      look.is_active = active->flag();
    if (const auto inverted = channel.find("inverted"); inverted && inverted->isFlag())
      look.is_inverted = inverted->flag();
    // sluice packs write `active` alone where their source had no look, which stays the default
    // one.
    says_something = says_something || look.color || look.window;
  }
  if (!says_something) looks.clear();
  return looks;
}

std::vector<std::string> omeroFaults(const JsonField& omero) {
  std::vector<std::string> faults;
  const auto channels = omero.isObject() ? omero.find("channels") : std::nullopt;
  if (!channels || !channels->isArray()) return faults;
  for (size_t i = 0; i < channels->size() && faults.size() < kMostFaults; ++i) {
    const JsonField channel = (*channels)[i];
    if (!channel.isObject()) continue;
    if (const auto color = channel.find("color"); color && !color->isNull() && !colorOf(*color))
      faults.push_back(fmt::format(
          "the colour of channel {}{} in omero is not six hexadecimal digits; another is chosen", i,
          color->isText() ? fmt::format(", '{}',", printable(color->text())) : std::string()));
    if (const auto window = channel.find("window"); window && saysRange(*window))
      faults.push_back(
          fmt::format("the window of channel {} in omero does not begin with a number below its "
                      "end; a range is chosen",
                      i));
  }
  return faults;
}

}  // namespace sluice
