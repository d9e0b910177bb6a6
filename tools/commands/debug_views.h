// --debug-view: pictures of how a frame came about, in addition to the frame's own (Li 2003,
// Figures 2, 3 and 8):
//   NAME.boxes.png    the middle slice and the growing boxes it cuts, by type (with boxes)
//   NAME.drawn_I.png  the boxes drawn before the map's update I + 1   (with occlusion)
//   NAME.map_I.png    the opacity map while these were drawn, from I = 1 on; white is opaque
#pragma once

#include <filesystem>
#include <vector>

#include "tools/scene/open_scene.h"

namespace sluice {

// Writes the phases of a frame drawn with FrameOptions::keep_phases. Returns the files written.
// Throws Error.
std::vector<std::filesystem::path> writeDebugViews(const std::filesystem::path& output,
                                                   const Frame& frame, Scene& scene,
                                                   const VolumeArguments& volume,
                                                   const IndexPlaces& places, Partition partition);
// Every name that these may have, whether it will be written or not.
std::vector<std::filesystem::path> debugViewNames(const std::filesystem::path& output);

}  // namespace sluice
