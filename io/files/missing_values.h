// Numbers that a file has where there is no value, such as _FillValue of NetCDF. Floats of such a
// number are read as NaN, which shows nothing. Integers have no NaN and stay as they are.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/sources/volume_source.h"

namespace sluice {

// The numbers that are to be read as NaN, of a type: none for integers.
std::vector<double> blankedNumbers(VoxelType type, std::span<const double> missing);
// Makes NaN of the voxels of these numbers. Requires: blankedNumbers() of the type.
void blank(VoxelType type, std::span<const double> numbers, std::span<std::byte> voxels);

// A line for people, without the volume's name, if integers of these stored numbers are drawn as
// values; empty if there is nothing to tell. `layout`: the type and the scaling of the values.
// `said_by`: where the file gives them.
std::string missingValuesNote(std::span<const double> missing, const VolumeLayout& layout,
                              std::string_view said_by = "_FillValue, missing_value");

// The same if stored numbers outside of these limits are no values by the file; empty if the limits
// are those of the type.
std::string invalidValuesNote(std::optional<double> least, std::optional<double> greatest,
                              const VolumeLayout& layout);

}  // namespace sluice
