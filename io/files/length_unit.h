// Units of length as files spell them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sluice {

// "millimeter" for "mm", "micrometer" for "um", "\u00B5m", "micron" and so on, in any case; a word
// that is not known comes back as it is, cut to one short printable line; empty for a pixel's or
// none.
std::string lengthUnit(std::string_view said);
// Whether OME-Zarr (NGFF 0.4 and 0.5) has this unit of space. `unit`: as lengthUnit() returns it.
bool isNgffUnit(std::string_view unit);
// The meters of one such unit, 0.001 for "millimeter"; nullopt for a word that is not known.
std::optional<double> metersOf(std::string_view unit);
// The number by which a length in `from` is multiplied to be one in `to`, 0.001 from "nanometer" to
// "micrometer"; 1 if either unit is not known. Both are as lengthUnit() returns them.
double unitRatio(std::string_view from, std::string_view to);

}  // namespace sluice
