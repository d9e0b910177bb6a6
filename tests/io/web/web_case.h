// WebCase: the stores that a test's server has.
#pragma once

#include "tests/io/zarr/zarr_case.h"

namespace sluice {

struct WebCase : ZarrCase {
  static constexpr const char* kScript = "make_zarr3.py";
  static constexpr const char* kModules = "numpy, numcodecs";
};

}  // namespace sluice
