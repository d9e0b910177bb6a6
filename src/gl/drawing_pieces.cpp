#include "src/gl/drawing_pieces.h"

#include <algorithm>
#include <cmath>

#include "src/device/drawing_cost.h"

namespace sluice {

DrawingPieces::DrawingPieces(const FrameSetup& setup)
    : DrawingPieces(setup, setup.lit || !setup.look_up->magnitudes.empty() ? kMostLitSamples
                                                                           : kMostSamples) {}

// That the box may be seen in, with one to spare for what is drawn larger than it is.
DrawingPieces::Rows DrawingPieces::rowsOf(const Box3& cells) const {
  const int height = setup_.size.height;
  double lo = 1, hi = -1;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p{static_cast<double>((corner & 1) != 0 ? cells.hi.x : cells.lo.x),
                  static_cast<double>((corner & 2) != 0 ? cells.hi.y : cells.lo.y),
                  static_cast<double>((corner & 4) != 0 ? cells.hi.z : cells.lo.z)};
    const auto row = [&](size_t r) {
      const auto& of = setup_.clip_from_index[r];
      return of[0] * p.x + of[1] * p.y + of[2] * p.z + of[3];
    };
    if (row(2) <= 0) return {0, height};
    lo = std::min(lo, row(1) / row(2));
    hi = std::max(hi, row(1) / row(2));
  }
  const auto pixel = [height](double at) { return (std::clamp(at, -1.0, 1.0) + 1) / 2 * height; };
  return {std::max(0, static_cast<int>(std::floor(pixel(lo))) - 1),
          std::min(height, static_cast<int>(std::ceil(pixel(hi))) + 1)};
}

std::vector<DrawingPiece> DrawingPieces::cut(std::span<const BoxDraw> boxes) {
  const int height = setup_.size.height;
  std::vector<DrawingPiece> pieces;
  DrawingPiece piece{.row_hi = height};
  if (++lists_ > kMostLists) {
    piece.waits = true;
    since_wait_ = 0;
    lists_ = 1;
  }
  for (size_t i = 0; i < boxes.size(); ++i) {
    const double samples = aboutSamples(setup_, boxes[i].cells);
    if (since_wait_ + samples > most_samples_) {
      const bool waits = since_wait_ > 0 || (piece.waits && piece.count == 0);
      if (piece.count > 0) pieces.push_back(piece);
      piece = {.first = i, .row_hi = height, .waits = waits};
      since_wait_ = 0;
      lists_ = 1;
    }
    if (samples <= most_samples_) {
      since_wait_ += samples;
      ++piece.count;
      continue;
    }
    const Rows rows = rowsOf(boxes[i].cells);
    const int bands = std::min(static_cast<int>(std::min(std::ceil(samples / most_samples_), 1e6)),
                               std::max(1, rows.hi - rows.lo));
    for (int band = 0; band < bands; ++band) {
      const auto row = [&](int of) {
        return rows.lo + static_cast<int>(int64_t{rows.hi - rows.lo} * of / bands);
      };
      pieces.push_back({i, 1, row(band), row(band + 1), piece.waits || band > 0});
    }
    since_wait_ = most_samples_;
    piece = {.first = i + 1, .row_hi = height};
  }
  if (piece.count > 0) pieces.push_back(piece);
  return pieces;
}

}  // namespace sluice
