// Framing: a camera's position and reach that make the visible part fill the picture.
//
// Ranges of values tell what is visible (src/classify/blocks/visible_cells.h), so that no voxel is
// read for it. Several cameras (a turn, a path) and several time steps share one framing, so that
// nothing grows, shrinks or stands still that should not. One thread at a time may use it.
#pragma once

#include <span>
#include <vector>

#include "src/base/values/vec.h"
#include "src/render/camera/camera.h"

namespace sluice {

// The corners that reach farthest of all boxes of cells that were added: a bounded number of points
// of the world, whose hull equals the boxes' hull but for a few hundredths of its size.
class VisibleHull {
 public:
  explicit VisibleHull(const VolumeLayout& layout);
  // Boxes of cells of the volume; empty ones add nothing.
  void add(std::span<const Box3> boxes);
  // Empty while nothing visible was added.
  std::vector<Vec3d> points() const;

 private:
  struct Farthest {
    Vec3d along;   // index space: how far an index position lies in one direction of the world
    double far;    // distance of `corner`
    Vec3d corner;  // index space
  };
  void add(const Box3& cells);

  VolumeLayout layout_;
  bool any_ = false;
  std::vector<Farthest> farthest_;
};

// Margins of a picture to keep clear of the volume, as shares of its width and height.
struct Room {
  double right = 0, bottom = 0;
};

// Shows the points in all cameras that have no look_at, with a small margin at zoom 1: one camera's
// picture is centred on them, several turn about their middle. nullopt: no point or no such camera.
// Throws Error as requireValid() does. Requires: room below 1.
std::optional<Framing> framingOf(std::span<const Vec3d> points, std::span<const Camera> cameras,
                                 WorldFrame frame, PictureSize size, Room room = {});

}  // namespace sluice
