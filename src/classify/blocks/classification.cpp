#include "src/classify/blocks/classification.h"

#include <algorithm>

#include "src/base/memory/large_pages.h"
#include "src/classify/blocks/classifier.h"

namespace sluice {
namespace {

ObjectBlock objectOf(int64_t block, const Box3& cells, const Box3& owned, int64_t time) {
  ObjectBlock object;
  object.name = {.time = time, .block = block};
  object.cells = cells;
  object.kind = cells == owned ? BlockClass::kBlack : BlockClass::kGrey;
  const Vec3i size = cells.size();
  object.trimming_axis = 2;
  for (int axis = 1; axis >= 0; --axis)
    if (size[axis] < size[object.trimming_axis]) object.trimming_axis = axis;
  return object;
}

Box3 ownedCells(const BlockLayout& layout, int64_t block) {
  return layout.ownedCells(layout.indexOf(block));
}

}  // namespace

VisibleBlocks classify(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                       WorkerPool& pool, int64_t time) {
  VisibleBlocks result;
  std::vector<std::vector<ObjectBlock>> parts(tasksOf(ranges));
  visitDeviceType(ranges.map.type, [&](auto tag) {
    const Classifier<decltype(tag)> classifier(ranges, table, crop);
    classifyInTasks(ranges, pool, [&](size_t task, size_t from, size_t to) {
      for (size_t held = from; held < to; ++held) {
        if (!classifier.mayShow(held)) continue;
        const Box3 owned = ownedCells(ranges.layout, ranges.blocks[held]);
        const Box3 cells = classifier.shownCells(held, owned);
        if (!cells.empty())
          parts[task].push_back(objectOf(ranges.blocks[held], cells, owned, time));
      }
    });
  });
  size_t visible = 0;
  for (const auto& part : parts) visible += part.size();
  reserveLarge(result.blocks, visible);
  for (const auto& part : parts)
    result.blocks.insert(result.blocks.end(), part.begin(), part.end());
  visitWhole(ranges, table, crop, [&](int64_t block) {
    const Box3 owned = ownedCells(ranges.layout, block);
    const Box3 cells = intersect(owned, crop);
    if (!cells.empty()) result.blocks.push_back(objectOf(block, cells, owned, time));
  });
  if (result.blocks.size() > visible) std::ranges::sort(result.blocks, {}, &ObjectBlock::name);
  for (const ObjectBlock& object : result.blocks)
    ++(object.kind == BlockClass::kBlack ? result.black : result.grey);
  result.white = ranges.layout.blockCount() - result.grey - result.black;
  return result;
}

}  // namespace sluice
