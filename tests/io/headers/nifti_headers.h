// NIfTI headers as the tests of their fields and of whole files begin with.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "src/base/sources/volume_source.h"

namespace sluice::nifti_test {

inline constexpr Vec3i kDims{5, 4, 3};

// A header under construction; the offsets are from the standard's nifti1.h and nifti2.h.
class HeaderBytes {
 public:
  explicit HeaderBytes(size_t size) : bytes_(size, '\0') {}

  template <class T>
  HeaderBytes& set(size_t offset, T value) {
    std::memcpy(bytes_.data() + offset, &value, sizeof(T));
    return *this;
  }
  HeaderBytes& text(size_t offset, std::string_view value) {
    std::copy(value.begin(), value.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// NIfTI-1, 5 x 4 x 3 i16, single file, pixdim 1 2 3.
inline HeaderBytes plainHeader() {
  HeaderBytes h(352);
  h.set<int32_t>(0, 348).text(344, "n+1");
  const std::array<int16_t, 8> dim = {3, 5, 4, 3, 1, 1, 1, 1};
  for (size_t i = 0; i < 8; ++i) h.set<int16_t>(40 + 2 * i, dim[i]);
  h.set<int16_t>(70, 4).set<int16_t>(72, 16);
  for (size_t i = 0; i < 4; ++i) h.set<float>(76 + 4 * i, i == 0 ? 1.0F : static_cast<float>(i));
  return h.set<float>(108, 352);
}

inline void expectNear(Vec3d actual, Vec3d expected, double tolerance = 1e-6) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(actual[axis], expected[axis], tolerance) << axis;
}

inline Vec3d worldOf(const VolumeLayout& layout, Vec3d index) {
  Vec3d world = layout.origin;
  for (int axis = 0; axis < 3; ++axis)
    world = world + layout.axes[static_cast<size_t>(axis)] * (layout.spacing[axis] * index[axis]);
  return world;
}

}  // namespace sluice::nifti_test
