// What a picture differs from the plain one by: every block loaded and drawn whole.
#pragma once

#include "src/render/frame_options.h"
#include "tools/scene.h"

namespace sluice {

struct Verification {
  double max_difference = 0, mean_difference = 0;  // in 1/255
};

// Draws the scene's plain picture, which is its last: it is left with other options. Of several
// ranks one does it alone.
Verification verify(Scene& scene, FrameOptions options, const Picture& picture);

}  // namespace sluice
