// Numbers that a file has where there is no value, such as _FillValue of NetCDF.
#pragma once

#include <span>
#include <string>

namespace sluice {

// A line for people: voxels of these stored numbers are drawn as values. Empty if all are NaN,
// which shows nothing, or none is given. value = stored * scale + offset. `name`: the volume's.
std::string missingValuesNote(const std::string& name, std::span<const double> stored, double scale,
                              double offset);

}  // namespace sluice
