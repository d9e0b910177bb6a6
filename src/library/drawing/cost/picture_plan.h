// The public plan of a picture of a scene.
#pragma once

#include <sluice/report.h>

#include <vector>

#include "src/library/drawing/scene/scene.h"

namespace sluice {

// `steps`: of each layer. Throws as plannedChannels() does.
PicturePlan planOf(const Scene& scene, const std::vector<TimeStep>& steps,
                   const FrameOptions& options);

}  // namespace sluice
