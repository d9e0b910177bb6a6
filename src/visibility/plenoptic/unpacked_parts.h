// UnpackedParts: the extinctions of the parts of some opacity functions, in the form that the
// estimate's loops read. Neighbouring tiles meet the same blocks, and the next step mostly the same
// functions, so that few are unpacked twice. Bounded in size; one thread at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/visibility/plenoptic/opacity_function.h"

namespace sluice {

class UnpackedParts {
 public:
  // See PartValues.
  struct Parts {
    int32_t number = -1;  // the function's; none yet
    std::vector<uint32_t> cubes;
    std::vector<float> extinction;
  };

  // The most bytes that the functions take, for blocks of `parts` parts.
  static size_t mostBytes(size_t parts) { return places(parts) * bytesOf(parts); }

  // The parts of function `number`, for a block of `parts` parts. `extinction` maps its bytes to
  // extinctions and is the same at each call. Holds until the next call.
  const Parts& of(int32_t number, const OpacityFunction& function, size_t parts,
                  const std::array<float, 256>& extinction);

 private:
  static size_t bytesOf(size_t parts) {
    return std::max<size_t>(parts, 1) * 4 * (sizeof(uint32_t) + sizeof(float));
  }
  static size_t places(size_t parts) {
    constexpr size_t kBytes = size_t{4} << 20, kLeastPlaces = 16;
    return std::max(kBytes / bytesOf(parts), kLeastPlaces);
  }

  std::vector<Parts> places_;
};

}  // namespace sluice
