// Values that views and devices share.
#pragma once

namespace sluice {

enum class Projection { kOrtho, kPerspective };

struct PictureSize {
  int width = 512, height = 512;

  friend bool operator==(const PictureSize&, const PictureSize&) = default;
  double aspect() const { return static_cast<double>(width) / height; }
};

}  // namespace sluice
