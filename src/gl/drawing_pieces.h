// DrawingPieces: cuts drawing into pieces of a bounded number of samples, so that a driver that can
// only be waited for answers within a fraction of a second. A box that is larger by itself is drawn
// in bands of rows. Pieces leave the order of boxes at each pixel as it is. Lists of boxes are
// counted too: software GL keeps 128 KiB for each until it is waited for. One thread.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "src/device/frame_values.h"

namespace sluice {

struct DrawingPiece {
  size_t first = 0, count = 0;  // into the boxes given
  int row_lo = 0, row_hi = 0;   // rows of the picture, counted upwards
  bool waits = false;           // for everything drawn so far, before this piece
};

class DrawingPieces {
 public:
  // About a quarter of a second of software GL on two cores; a lit sample reads seven texels
  // instead of one.
  static constexpr double kMostSamples = 1 << 26, kMostLitSamples = 1 << 24;

  // Lists between two pieces that wait, at most.
  static constexpr int kMostLists = 256;

  // For frames with this setup, which must outlive the object.
  explicit DrawingPieces(const FrameSetup& setup);
  DrawingPieces(const FrameSetup& setup, double most_samples)
      : setup_(setup), most_samples_(most_samples) {}

  // The pieces in order; all boxes, or all rows of a box, once.
  std::vector<DrawingPiece> cut(std::span<const BoxDraw> boxes);

 private:
  struct Rows {
    int lo, hi;
  };
  Rows rowsOf(const Box3& cells) const;

  const FrameSetup& setup_;
  const double most_samples_;
  // Work since the last piece that waited.
  double since_wait_ = 0;  // samples
  int lists_ = 0;
};

}  // namespace sluice
