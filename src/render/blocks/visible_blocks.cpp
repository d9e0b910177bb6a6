#include "src/render/blocks/visible_blocks.h"

namespace sluice {

VisibleBlocksPtr ClassifiedBlocks::choose(const BlockQuestion& question) {
  const BlockQuestion& q = question;
  return memo_.of({q.step, q.look, q.crop, q.looks_around}, [&] {
    const auto how = q.looks_around ? classifyAround : classify;
    const auto ranges = listedRanges(q.step.ranges, *q.step.source, q.step.time);
    return how(*ranges, q.look->table, q.crop, pool_, q.step.time);
  });
}

}  // namespace sluice
