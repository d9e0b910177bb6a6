#include "io/files/length_unit.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>

#include "src/base/values/letter_case.h"

namespace sluice {
namespace {

struct Unit {
  std::string_view name;
  double meters;
  std::initializer_list<std::string_view> spellings;
};

// The micro sign and the Greek letter as UTF-8 and Latin-1, and as text escapes.
const Unit kUnits[] = {
    {"angstrom", 1e-10, {"a", "angstrom", "\xc3\x85", "\xe2\x84\xab"}},
    {"nanometer", 1e-9, {"nm", "nanometer", "nanometre", "nanometers"}},
    {"micrometer",
     1e-6,
     {"um", "micron", "microns", "micrometer", "micrometre", "micrometers", "\xc2\xb5m",
      "\xce\xbcm", "\xb5m", "\\u00b5m"}},
    {"millimeter", 1e-3, {"mm", "millimeter", "millimetre", "millimeters"}},
    {"centimeter", 1e-2, {"cm", "centimeter", "centimetre", "centimeters"}},
    {"meter", 1, {"m", "meter", "metre", "meters"}},
    {"kilometer", 1e3, {"km", "kilometer", "kilometre"}},
    {"inch", 0.0254, {"in", "inch", "inches"}},
};
constexpr std::string_view kNoUnits[] = {"",     "pixel", "pixels",  "voxel", "voxels",
                                         "none", "null",  "unknown", "???"};

}  // namespace

std::string lengthUnit(std::string_view said) {
  constexpr size_t kLongest = 40;
  std::string word(said.substr(0, kLongest));
  const std::string lower = lowercase(word);
  if (std::ranges::find(kNoUnits, lower) != std::end(kNoUnits)) return "";
  for (const Unit& unit : kUnits)
    if (std::find(unit.spellings.begin(), unit.spellings.end(), lower) != unit.spellings.end())
      return std::string(unit.name);
  for (char& c : word)
    if (c < ' ' || c > '~') c = '?';
  return word;
}

bool isNgffUnit(std::string_view unit) {
  constexpr std::string_view kNames[] = {
      "angstrom",   "attometer",  "centimeter", "decimeter",  "exameter",   "femtometer",
      "foot",       "gigameter",  "hectometer", "inch",       "kilometer",  "megameter",
      "meter",      "micrometer", "mile",       "millimeter", "nanometer",  "parsec",
      "petameter",  "picometer",  "terameter",  "yard",       "yoctometer", "yottameter",
      "zeptometer", "zettameter"};
  return std::ranges::find(kNames, unit) != std::end(kNames);
}

std::optional<double> metersOf(std::string_view unit) {
  const auto* const found = std::ranges::find(kUnits, unit, &Unit::name);
  return found == std::end(kUnits) ? std::nullopt : std::optional(found->meters);
}

double unitRatio(std::string_view from, std::string_view to) {
  const auto from_meters = metersOf(from), to_meters = metersOf(to);
  if (!from_meters || !to_meters || from == to) return 1;
  // Most ratios are powers of ten, which the division misses by its rounding.
  const auto rounded = [](double ratio) {
    const double whole = std::round(ratio);
    return std::abs(ratio - whole) < 1e-9 * ratio ? whole : ratio;
  };
  return *from_meters > *to_meters ? rounded(*from_meters / *to_meters)
                                   : 1 / rounded(*to_meters / *from_meters);
}

}  // namespace sluice
