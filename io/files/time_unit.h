// Units of time as files spell them.
#pragma once

#include <string>
#include <string_view>

namespace sluice {

// The unit's name in OME-Zarr: "millisecond" for "ms" and "msec", "microsecond" for "us" and
// "\u00B5s", "megasecond" for "Ms". Symbols differ by their case, words do not. A word that is not
// known comes back as it is, cut to one short printable line.
std::string timeUnit(std::string_view said);

}  // namespace sluice
