// The facts of a picture that tell which of its options change nothing
// (src/options/idle_options.h). Pure functions.
#pragma once

#include <vector>

#include "src/library/drawing/scene/channel_shares.h"
#include "src/library/drawing/scene/scene.h"
#include "src/options/idle_options.h"

namespace sluice {

// The facts that the options and the layers tell; the others are as for a film that is drawn.
PictureFacts pictureFacts(const LookArguments& look, const FrameOptions& frame,
                          const MachineOptions& machine, const std::vector<LayerLook>& layers);

// The same of a scene, with its light.
PictureFacts pictureFacts(const Scene& scene, const FrameOptions& frame);

}  // namespace sluice
