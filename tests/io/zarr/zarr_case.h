// A Zarr store that a script of Python wrote, and the volume that must be read from it.
#pragma once

#include <istream>
#include <string>

#include "io/zarr/reading/zarr_source.h"

namespace sluice {

// A store of make_zarr.py.
struct ZarrCase {
  static constexpr const char* kScript = "make_zarr.py";
  static constexpr const char* kModules = "numpy, zarr, numcodecs";

  std::string name, type;
  Vec3i dims;
  int64_t steps = 1, channel = -1;
  bool missing = false;

  ZarrOptions options() const {
    ZarrOptions options;
    if (channel >= 0) options.channel = channel;
    return options;
  }
  friend std::istream& operator>>(std::istream& line, ZarrCase& c) {
    return line >> c.name >> c.type >> c.dims.x >> c.dims.y >> c.dims.z >> c.steps >> c.channel >>
           c.missing;
  }
};

}  // namespace sluice
