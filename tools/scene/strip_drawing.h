// Pictures that are too large for their share of --memory are drawn and written strip by strip,
// from the top down. Strips share the plan and the contents of the levels; a strip reads and draws
// the blocks that it shows. The file is the same, byte by byte.
#pragma once

#include <optional>
#include <vector>

#include "src/device/picture_rows.h"
#include "tools/outputs/picture_output.h"
#include "tools/scene/scene.h"

namespace sluice {

// The strips of the scene's pictures; a single one if pictures are drawn whole. Ranks draw whole
// pictures, since they exchange parts of the whole.
std::vector<PictureRows> stripsFor(const Scene& scene);

// A frame that was drawn and given to a writer.
struct WrittenFrame {
  FrameReport report;  // the sum of all strips
  VisibleBlocksPtr blocks;
  double write_seconds = 0;
  bool shows_something = false;
  std::optional<Frame> whole;  // set only if the picture was drawn whole
};
// Draws the session's next frame and gives its rows to `writer`, if there is one, but commits
// nothing. Throws Error and Interrupted; the device draws whole pictures again afterwards.
WrittenFrame drawFrameOf(Scene& scene, const std::vector<PictureRows>& strips,
                         PictureWriter* writer);

}  // namespace sluice
