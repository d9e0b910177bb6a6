// Annotations: the marks that make a picture readable: orientation axes, a scale bar and a colour
// bar.
//
// Drawn over a finished picture, whatever its background: each line and letter has a rim of the
// opposite brightness. Sizes follow the picture's shorter side. Plain functions, any thread.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "src/base/values/picture.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/render/camera/camera.h"
#include "src/render/camera/camera_framing.h"

namespace sluice {

// A patch of a colour and what it stands for: a label, a channel.
struct LegendEntry {
  std::string text;
  Vec3d rgb;
};

struct Annotations {
  View view;
  // The scale bar measures at this point's distance in perspective.
  Vec3d target;
  WorldFrame frame = WorldFrame::kNone;  // names the axes: R, A, S of patients, else x, y, z
  std::string unit;                      // unit of the world, as in VolumeLayout
  TransferFunction transfer;
  ValueRange range;  // the values that the bar of colours is about
  // Labels or channels that show, in a picture of labels or of several channels. Each gets a patch
  // of its colour, in place of the colour bar.
  std::vector<LegendEntry> legend;
  // Background of the picture, if it has one.
  std::optional<std::array<float, 3>> background;
};

inline constexpr int kLeastAnnotatedPixels = 128;  // for both sides

// The picture with all three drawn over it; depth is kept. Throws Error when the picture is smaller
// than kLeastAnnotatedPixels, or no font or no Cairo is installed. `picture` may be a strip of the
// picture, whole rows from `first_row` on, counted from the top. Requires: view.size is the whole
// picture's.
Picture annotated(const Picture& picture, const Annotations& annotations, int first_row = 0);

// The margins of a picture that annotations take, so that the volume can be framed clear of them.
Room annotationRoom(PictureSize size);

}  // namespace sluice
