#include "src/render/blocks/visible_blocks.h"

namespace sluice {

VisibleBlocksPtr ClassifiedBlocks::choose(const BlockQuestion& question) {
  const BlockQuestion& q = question;
  return memo_.of({q.step, q.look, q.crop, q.looks_around}, [&] {
    const auto how = q.looks_around ? classifyAround : classify;
    return how(*q.step.ranges, q.look->table, q.crop, pool_, q.step.time);
  });
}

}  // namespace sluice
