#include "src/render/look.h"

#include <utility>

namespace sluice {

Look makeLook(const TimeStep& step, TransferFunction transfer, Mode mode) {
  if (mode != Mode::kComposite) transfer.gradients.clear();
  OpacityTable table(transfer, step.ranges->map, step.ranges->device_range);
  return {std::move(transfer), std::move(table)};
}

}  // namespace sluice
