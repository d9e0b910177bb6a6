// The scene of a volume that the library has open.
#pragma once

#include <sluice/options.h>

#include <memory>

#include "src/library/drawing/scene/scene.h"
#include "src/library/opening/opened_volume.h"

namespace sluice {

// The frames that a scene's session is opened for. Throws Error if the options do not suit a rank's
// part.
FrameOptions sessionFrame(const OpenedVolume* opened, const LookOptions& look,
                          const RendererOptions& options);

// Throws Error if the device cannot be had, and as sessionFrame() does.
Scene sceneOf(const std::shared_ptr<const OpenedVolume>& opened, const LookOptions& look,
              const RendererOptions& options);

}  // namespace sluice
