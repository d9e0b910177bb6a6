// UnpackedParts: what the parts of some opacity functions hide, as the estimate's loops take it.
// Neighbouring tiles meet the same blocks, and the next step mostly the same functions, so that few
// are unpacked twice. Of a bounded size; one thread at a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sluice {

class UnpackedParts {
 public:
  // See PartValues.
  struct Parts {
    int32_t function = -1;  // none yet
    std::vector<uint32_t> cubes;
    std::vector<float> extinction;
  };

  // Where a function of so many parts goes: there may still be another one.
  Parts& placeOf(int32_t function, size_t parts) {
    if (places_.empty()) {
      const size_t a_place = std::max<size_t>(parts, 1) * 4 * (sizeof(uint32_t) + sizeof(float));
      places_.resize(std::max(kBytes / a_place, kLeastPlaces));
    }
    return places_[static_cast<size_t>(function) % places_.size()];
  }

 private:
  static constexpr size_t kBytes = size_t{4} << 20, kLeastPlaces = 16;
  std::vector<Parts> places_;
};

}  // namespace sluice
