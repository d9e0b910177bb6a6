// The axes of an HDF5 data set and the meaning of its numbers, from its attributes and dimension
// scales. Pure functions.
//
// Axes have their names from vigra's axistags, DIMENSION_LABELS or the scales (NetCDF's
// dimensions). Spacing and origin come from element_size_um (z, y, x), or from the numbers of the
// scales if their units agree. Source: the CF conventions for axis, units, scale_factor,
// add_offset, _FillValue, missing_value, valid_range, valid_min and valid_max; NetCDF for
// _Unsigned.
#pragma once

#include <string>
#include <vector>

#include "io/hdf5/hdf5_module.h"
#include "io/zarr/metadata/zarr_image.h"

namespace sluice {

struct Hdf5Image {
  ZarrImage image;
  bool is_unsigned = false;        // integers that are stored as signed ones
  std::vector<std::string> notes;  // for people, one line each
};

// `axes`: of the array, which has more than the data set if that has fewer than three. Without
// names, the first of four axes is the channel if `channel_wanted`. Throws Error, which starts with
// `name`.
Hdf5Image hdf5ImageOf(const Hdf5Description& description, size_t axes, bool channel_wanted,
                      const std::string& name);

}  // namespace sluice
