#include "src/render/blocks/visible_blocks.h"

namespace sluice {

VisibleBlocksPtr ClassifiedBlocks::choose(const BlockQuestion& question) {
  const BlockQuestion& q = question;
  return memo_.of({q.step, q.look, q.crop}, [&] {
    return classify(*q.step.ranges, q.look->table, q.crop, pool_, q.step.time);
  });
}

}  // namespace sluice
