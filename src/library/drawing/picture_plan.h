// The public plan of a picture of a scene.
#pragma once

#include <sluice/report.h>

#include "src/library/drawing/scene.h"

namespace sluice {

PicturePlan planOf(const Scene& scene, const TimeStep& step, const FrameOptions& options);

}  // namespace sluice
