// Finds why a picture shows nothing, so that a person who gets an empty picture knows what to
// change.
#pragma once

#include <string>

#include "src/base/values/picture.h"
#include "src/library/opening/indexed_volume.h"
#include "src/render/camera/frame_options.h"

namespace sluice {

// Whether no pixel shows anything: each has less than kLeastOpacity. False for a picture without
// pixels; of one that a device keeps for a screen, the device tells (ScreenPicture).
bool showsNothing(const Picture& picture);

// The inputs that a picture was drawn from.
struct DrawnPicture {
  const IndexedVolume& volume;
  int64_t time = 0;
  const TransferFunction& transfer;
  const FrameOptions& options;  // the camera as it was framed
  double missing_share = 0;     // FrameReport::missing_share
};

// The reason that a picture shows nothing, in one line: "the crop box holds no cell of the volume".
// Looks at ranges, never at voxels but of a step that has no index. Requires: showsNothing().
std::string whyEmpty(const DrawnPicture& drawn, const IndexPass& pass);

}  // namespace sluice
