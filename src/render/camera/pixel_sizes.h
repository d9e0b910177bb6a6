// PixelSizes: the width in pixels of a level's voxels at their place in a view.
#pragma once

#include <optional>

#include "src/base/sources/volume_source.h"
#include "src/render/camera/camera.h"
#include "src/volume/pyramid.h"

namespace sluice {

// Refers to its arguments, which must outlive it.
class PixelSizes {
 public:
  PixelSizes(const VolumeLayout& volume, const View& view)
      : volume_(volume), view_(view), aspect_(view.size.aspect()) {}

  // Pixels that the widest axis of the level's voxels is long, seen from the side, where these
  // finest cells are nearest to the eye; 0 if the picture shows none of them, infinite around the
  // eye.
  double of(const LevelLayout& level, const Box3& cells) const;
  // World units from the eye to the middle of the cells, along the view.
  double depthOf(const Box3& cells) const;

 private:
  // World units across; nullopt: the cells lie outside the picture.
  std::optional<double> smallestPixel(const Box3& cells) const;

  const VolumeLayout& volume_;
  const View& view_;
  const double aspect_;
};

}  // namespace sluice
