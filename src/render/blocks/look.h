// Look: colours and opacities of a frame's values, the second value of its chain: the transfer
// function as the frame's mode uses it, and its table for the step's device values. Immutable.
#pragma once

#include <memory>

#include "src/classify/transfer/opacity_table.h"
#include "src/device/frame_values.h"
#include "src/render/blocks/time_step.h"

namespace sluice {

struct Look {
  TransferFunction transfer;
  OpacityTable table;
  LookUpPtr look_up;  // the same for devices
};
using LookPtr = std::shared_ptr<const Look>;

// The table for a volume with this finest spacing, see index_space.h.
LookUp lookUp(const OpacityTable& table, double finest_spacing);

// Modes other than composite look at values alone: gradients, spreads and surfaces make no
// difference to them.
Look makeLook(const TimeStep& step, TransferFunction transfer, Mode mode);

}  // namespace sluice
