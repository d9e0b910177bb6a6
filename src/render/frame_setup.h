// What a device needs to know of a frame, from the view, the volume's layout and the options. Pure
// functions.
#pragma once

#include "src/classify/opacity_table.h"
#include "src/render/device.h"
#include "src/render/frame_options.h"
#include "src/texture/texture_plan.h"
#include "src/volume/slice_ranges.h"

namespace sluice {

FrameSetup frameSetup(const View& view, const VolumeLayout& layout, const OpacityTable& table,
                      const ValueMap& map, const FrameOptions& options);

// Where the eye is for ordering blocks front to back.
EyePosition eyePosition(const View& view, const VolumeLayout& layout);

}  // namespace sluice
