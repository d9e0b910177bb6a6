#include "tests/classify/blocks/classified.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "src/classify/blocks/object_boxes.h"

namespace sluice {
namespace {

// Compares the boxes of all blocks with the list of visible ones.
void expectSameBoxes(const VisibleBlocks& listed, const ObjectBoxes& boxes,
                     const BlockLayout& layout) {
  size_t next = 0;
  for (int64_t block = 0; block < layout.blockCount(); ++block) {
    const bool is_listed = next < listed.blocks.size() && listed.blocks[next].name.block == block;
    EXPECT_EQ(boxes.of(layout.indexOf(block)), is_listed ? listed.blocks[next++].cells : Box3());
  }
}

}  // namespace

TransferFunction transferOf(std::vector<OpacityPoint> opacities) {
  TransferFunction transfer;
  transfer.colors = {{0, {1, 1, 1}}};
  transfer.opacities = std::move(opacities);
  return transfer;
}
TransferFunction band(double lo, double hi) {
  return transferOf({{lo, 0}, {lo, 0.5}, {hi, 0.5}, {hi, 0}});
}
TransferFunction threshold(double t) {
  return transferOf({{t, 0}, {t, 0.5}});
}

Box3 allCells(const BlockLayout& layout) {
  return {{0, 0, 0}, layout.dims - Vec3i{1, 1, 1}};
}

VisibleBlocks classified(const SliceRanges& ranges, const TransferFunction& transfer,
                         std::optional<Box3> crop, int threads) {
  WorkerPool pool(threads);
  const OpacityTable table(transfer, ranges.map, ranges.device_range);
  const Box3 cells = crop.value_or(allCells(ranges.layout));
  const VisibleBlocks result = classify(ranges, table, cells, pool);
  EXPECT_EQ(countVisible(ranges, table, cells, pool), static_cast<int64_t>(result.blocks.size()));
  constexpr int64_t kMostCompared = 100'000;
  if (ranges.layout.blockCount() <= kMostCompared)
    expectSameBoxes(result, ObjectBoxes(std::make_shared<const SliceRanges>(ranges), table, cells),
                    ranges.layout);
  return result;
}

}  // namespace sluice
