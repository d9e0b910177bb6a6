#include "io/files/length_unit.h"

#include <algorithm>
#include <cctype>
#include <initializer_list>

namespace sluice {
namespace {

struct Unit {
  std::string_view name;
  std::initializer_list<std::string_view> spellings;
};

}  // namespace

std::string lengthUnit(std::string_view said) {
  // The micro sign and the Greek letter as UTF-8 and Latin-1, and as text escapes.
  static const Unit kUnits[] = {
      {"angstrom", {"a", "angstrom", "\xc3\x85", "\xe2\x84\xab"}},
      {"nanometer", {"nm", "nanometer", "nanometre", "nanometers"}},
      {"micrometer",
       {"um", "micron", "microns", "micrometer", "micrometre", "micrometers", "\xc2\xb5m",
        "\xce\xbcm", "\xb5m", "\\u00b5m"}},
      {"millimeter", {"mm", "millimeter", "millimetre", "millimeters"}},
      {"centimeter", {"cm", "centimeter", "centimetre", "centimeters"}},
      {"meter", {"m", "meter", "metre", "meters"}},
      {"kilometer", {"km", "kilometer", "kilometre"}},
      {"inch", {"in", "inch", "inches"}},
      {"", {"", "pixel", "pixels", "voxel", "voxels", "none", "null", "unknown", "???"}},
  };
  constexpr size_t kLongest = 40;
  std::string word(said.substr(0, kLongest));
  std::string lower = word;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const Unit& unit : kUnits)
    if (std::find(unit.spellings.begin(), unit.spellings.end(), lower) != unit.spellings.end())
      return std::string(unit.name);
  for (char& c : word)
    if (c < ' ' || c > '~') c = '?';
  return word;
}

}  // namespace sluice
