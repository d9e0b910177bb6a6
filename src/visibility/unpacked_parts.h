// UnpackedParts: what the parts of some opacity functions hide, as the estimate's loops take it.
// Neighbouring tiles meet the same blocks, and the next step mostly the same functions, so that few
// are unpacked twice. Of a bounded size; one thread at a time.
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

  // Of function `number`, for a block of so many parts; `extinction`: what its bytes stand for, the
  // same at each call. Holds until the next call.
  const Parts& of(int32_t number, const OpacityFunction& function, size_t parts,
                  const std::array<float, 256>& extinction);

 private:
  std::vector<Parts> places_;
};

}  // namespace sluice
