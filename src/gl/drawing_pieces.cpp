#include "src/gl/drawing_pieces.h"

#include <algorithm>
#include <cmath>

#include "src/device/drawing_cost.h"
#include "src/device/pictures/picture_rows.h"

namespace sluice {

namespace {

bool readsGradients(const FrameSetup& setup) {
  return setup.lit || !setup.look_up->magnitudes.empty();
}

// The limit for the samples of one channel: each further one takes as many in the same box.
double mostSamples(const FrameSetup& setup) {
  const bool gradients = readsGradients(setup) || std::ranges::any_of(setup.others, readsGradients);
  return (gradients ? DrawingPieces::kMostLitSamples : DrawingPieces::kMostSamples) /
         static_cast<double>(1 + setup.others.size());
}

}  // namespace

DrawingPieces::DrawingPieces(const FrameSetup& setup) : DrawingPieces(setup, mostSamples(setup)) {}

DrawingPieces::Rows DrawingPieces::rowsOf(const Box3& cells) const {
  const PictureRows rows = sluice::rowsOf(setup_, cells);
  return {rows.lo, rows.hi};
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
    // One box alone has too many samples: it is drawn in bands of rows, which the driver finishes
    // one by one.
    const int bands = std::min(static_cast<int>(std::min(std::ceil(samples / most_samples_), 1e6)),
                               std::max(1, rows.hi - rows.lo));
    for (int band = 0; band < bands; ++band) {
      const auto row = [&](int of) {
        return rows.lo + static_cast<int>(int64_t{rows.hi - rows.lo} * of / bands);
      };
      pieces.push_back({i, 1, row(band), row(band + 1), piece.waits || band > 0});
    }
    // Whatever follows waits first.
    since_wait_ = most_samples_;
    piece = {.first = i + 1, .row_hi = height};
  }
  if (piece.count > 0) pieces.push_back(piece);
  return pieces;
}

}  // namespace sluice
