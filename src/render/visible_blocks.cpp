#include "src/render/visible_blocks.h"

namespace sluice {

VisibleBlocksPtr ClassifiedBlocks::choose(const BlockQuestion& question) {
  const auto& [step, look, crop, view] = question;
  return memo_.of({step, look, crop},
                  [&] { return classify(*step.ranges, look->table, crop, pool_, step.time); });
}

}  // namespace sluice
