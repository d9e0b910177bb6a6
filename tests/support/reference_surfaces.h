// Finds the places where a ray meets surfaces on a short way, for the reference renderer.
#pragma once

#include <functional>
#include <vector>

#include "src/classify/transfer/transfer_function.h"

namespace sluice {

struct ReferenceHits {
  struct Hit {
    double part = 0;  // of the way, 0 to 1
    const IsoSurface* surface = nullptr;
  };
  std::vector<Hit> hits;  // in the order of the way
  // The greatest opacity that surfaces gain or lose if rounding moves the value at an end.
  double doubt = 0;
};

// `value_at`: the value at a part of the way. `range`: between the volume's least and greatest
// value.
ReferenceHits surfaceHits(const std::vector<IsoSurface>& surfaces, double range,
                          const std::function<double(double part)>& value_at);

}  // namespace sluice
