// Annotations: what a picture needs to be read: orientation axes, a scale bar and a colour bar.
//
// Drawn over a finished picture, whatever its background: each line and letter has a rim of the
// opposite brightness. Sizes follow the picture's shorter side. Plain functions, any thread.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "src/base/picture.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/render/camera.h"
#include "src/render/camera_framing.h"

namespace sluice {

struct Annotations {
  View view;
  // Whose distance the scale bar measures at in perspective.
  Vec3d target;
  WorldFrame frame = WorldFrame::kNone;  // names the axes: R, A, S of patients, else x, y, z
  std::string unit;                      // of the world as VolumeLayout has it
  TransferFunction transfer;
  ValueRange range;  // all values of the volume
  // Of a transfer function of labels: those that show, each a patch of its colour in place of the
  // colour bar.
  std::vector<double> labels;
  // Of the picture, where it has one.
  std::optional<std::array<float, 3>> background;
};

inline constexpr int kLeastAnnotatedPixels = 128;  // of both sides

// The picture with all three drawn over it; depth is kept. Throws Error when the picture is smaller
// than kLeastAnnotatedPixels or no font is installed. `picture` may be a strip of the picture,
// whole rows from `first_row` on, counted from the top. Requires: view.size is the whole picture's.
Picture annotated(const Picture& picture, const Annotations& annotations, int first_row = 0);

// What they take of a picture's sides, for the volume to stand beside them.
Room annotationRoom(PictureSize size);

}  // namespace sluice
