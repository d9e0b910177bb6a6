#include "src/device/pictures/picture_rows.h"

#include <algorithm>
#include <cmath>

#include "src/base/error.h"
#include "src/base/values/corners.h"
#include "src/device/device.h"

namespace sluice {

StripsOfDevice::StripsOfDevice(Device& device) : device_(dynamic_cast<DrawsRows*>(&device)) {
  SLUICE_CHECK(device_ != nullptr);
}

StripsOfDevice::~StripsOfDevice() {
  // The device may draw other pictures afterwards, which are whole ones.
  device_->drawRows(std::nullopt);
}

std::optional<PictureRows> rowsOf(const Device& device) {
  const auto* draws_rows = dynamic_cast<const DrawsRows*>(&device);
  return draws_rows != nullptr ? draws_rows->rows() : std::nullopt;
}

PictureRows rowsOf(const FrameSetup& setup, const Box3& cells) {
  const int height = setup.size.height;
  double lo = 1, hi = -1;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p = toDouble(cornerOf(cells, corner));
    const auto row = [&](size_t r) {
      const auto& of = setup.clip_from_index[r];
      return of[0] * p.x + of[1] * p.y + of[2] * p.z + of[3];
    };
    if (row(2) <= 0) return {0, height};  // beside the eye: anywhere
    lo = std::min(lo, row(1) / row(2));
    hi = std::max(hi, row(1) / row(2));
  }
  // A row is added on either side for rounding, and for GL, whose proxy cubes are slightly
  // enlarged.
  const auto pixel = [height](double at) { return (std::clamp(at, -1.0, 1.0) + 1) / 2 * height; };
  return {std::max(0, static_cast<int>(std::floor(pixel(lo))) - 1),
          std::min(height, static_cast<int>(std::ceil(pixel(hi))) + 1)};
}

}  // namespace sluice
