#include "src/classify/blocks/classification.h"

#include <algorithm>
#include <atomic>
#include <unordered_map>

#include "src/base/memory/large_pages.h"
#include "src/classify/blocks/classifier.h"

namespace sluice {
namespace {

ObjectBlock objectOf(int64_t block, const Box3& cells, const Box3& owned, int64_t time) {
  ObjectBlock object;
  object.name = {.time = time, .block = block};
  object.cells = cells;
  object.kind = cells == owned ? BlockClass::kBlack : BlockClass::kGrey;
  object.trimming_axis = shortestAxis(cells.size());
  return object;
}

Box3 ownedCells(const BlockLayout& layout, int64_t block) {
  return layout.ownedCells(layout.indexOf(block));
}

void count(const BlockLayout& layout, VisibleBlocks& result) {
  for (const ObjectBlock& object : result.blocks)
    ++(object.kind == BlockClass::kBlack ? result.black : result.grey);
  result.white = layout.blockCount() - result.grey - result.black;
}

}  // namespace

int shortestAxis(Vec3i size) {
  int shortest = 2;
  // z first, then y: equal sizes keep z, in which texture blocks are not turned.
  for (int axis = 1; axis >= 0; --axis)
    if (size[axis] < size[shortest]) shortest = axis;
  return shortest;
}

VisibleBlocks classify(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                       WorkerPool& pool, int64_t time) {
  VisibleBlocks result;
  // Each task has a list of its own, which needs no lock, and the lists follow each other in the
  // order of blocks.
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
  // Whole blocks were added at the end. Without them the tasks' parts are in order.
  if (result.blocks.size() > visible) std::ranges::sort(result.blocks, {}, &ObjectBlock::name);
  count(ranges.layout, result);
  return result;
}

int64_t countVisible(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                     WorkerPool& pool) {
  std::atomic<int64_t> visible{0};
  visitDeviceType(ranges.map.type, [&](auto tag) {
    const Classifier<decltype(tag)> classifier(ranges, table, crop);
    classifyInTasks(ranges, pool, [&](size_t /*task*/, size_t from, size_t to) {
      int64_t of_task = 0;
      for (size_t held = from; held < to; ++held) {
        if (!classifier.mayShow(held)) continue;
        const Box3 owned = ownedCells(ranges.layout, ranges.blocks[held]);
        of_task += classifier.shownCells(held, owned).empty() ? 0 : 1;
      }
      visible += of_task;
    });
  });
  visitWhole(ranges, table, crop, [&](int64_t block) {
    visible += intersect(ownedCells(ranges.layout, block), crop).empty() ? 0 : 1;
  });
  return visible;
}

VisibleBlocks classifyAround(const SliceRanges& ranges, const OpacityTable& table, const Box3& crop,
                             WorkerPool& pool, int64_t time) {
  const BlockLayout& layout = ranges.layout;
  const Box3 all = boxOf(layout.dims - Vec3i{1, 1, 1});
  const auto around = [](const Box3& cells) {
    return Box3{cells.lo - Vec3i{1, 1, 1}, cells.hi + Vec3i{1, 1, 1}};
  };
  // Cells beside the crop show in samples inside it, which look at neighbours.
  const VisibleBlocks shown = classify(ranges, table, intersect(around(crop), all), pool, time);
  std::unordered_map<int64_t, Box3> boxes;
  boxes.reserve(shown.blocks.size());
  for (const ObjectBlock& object : shown.blocks) {
    const Box3 cells = intersect(around(object.cells), crop);
    // A box that reaches over its block's faces belongs to several blocks.
    const Box3 blocks = blocksOf(layout, cells);
    for (int64_t z = blocks.lo.z; z < blocks.hi.z; ++z)
      for (int64_t y = blocks.lo.y; y < blocks.hi.y; ++y)
        for (int64_t x = blocks.lo.x; x < blocks.hi.x; ++x) {
          const Box3 part = intersect(cells, layout.ownedCells({x, y, z}));
          const auto [box, is_new] = boxes.try_emplace(layout.idOf({x, y, z}), part);
          if (!is_new) box->second = unite(box->second, part);
        }
  }
  VisibleBlocks result;
  reserveLarge(result.blocks, boxes.size());
  for (const auto& [block, cells] : boxes)
    result.blocks.push_back(objectOf(block, cells, ownedCells(layout, block), time));
  std::ranges::sort(result.blocks, {}, &ObjectBlock::name);
  count(layout, result);
  return result;
}

}  // namespace sluice
