// UnpackedParts: the extinctions of the parts of some opacity functions, in the form that the
// estimate's loops read. Neighbouring tiles meet the same blocks, and the next step mostly the same
// functions, so that few are unpacked twice. Bounded in size; one thread at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/visibility/opacity_function.h"

namespace sluice {

class UnpackedParts {
 public:
  // See PartValues.
  struct Parts {
    int32_t number = -1;  // the function's; none yet
    std::vector<uint32_t> cubes;
    std::vector<float> extinction;
  };

  // The parts of function `number`, for a block of `parts` parts. `extinction` maps its bytes to
  // extinctions and is the same at each call. Holds until the next call.
  const Parts& of(int32_t number, const OpacityFunction& function, size_t parts,
                  const std::array<float, 256>& extinction);

 private:
  std::vector<Parts> places_;
};

}  // namespace sluice
