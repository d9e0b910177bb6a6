#include "src/render/session/chosen_boxes.h"

#include <utility>

#include "src/classify/boxes/box_visibility.h"

namespace sluice {

ChosenBoxes::ChosenBoxes(const TimeStep& step, LookPtr look, FramePlanPtr plan, double step_vox,
                         std::shared_ptr<BoxStore> store, uint64_t budget_bytes)
    : step_(step),
      look_(std::move(look)),
      plan_(std::move(plan)),
      step_vox_(step_vox),
      store_(std::move(store)),
      budget_bytes_(budget_bytes) {}

VisibleBoxesPtr ChosenBoxes::find(BlockPosition position) const {
  const MutexLock lock(mutex_);
  const auto found = kept_.find(position);
  return found == kept_.end() ? nullptr : found->second;
}

VisibleBoxesPtr ChosenBoxes::choose(BlockPosition position, bool may_build,
                                    const ReadPurpose& purpose) const {
  if (VisibleBoxesPtr kept = find(position)) return kept;
  const TextureBlock& block = plan_->textures.blocks[position];
  // Growing boxes are made of the finest level's voxels.
  if (block.name.level > 0) return nullptr;
  const BoxTreePtr tree =
      may_build ? store_->tree(block.name.block, purpose) : store_->treeIfMade(block.name.block);
  if (tree == nullptr) return nullptr;
  const BoxVisibility visibility(look_->table, step_.source->layout());
  auto chosen = std::make_shared<const VisibleBoxes>(
      *tree, visibility, translate(block.cells, firstCell(position) * -1), boxCost(1 / step_vox_));
  const MutexLock lock(mutex_);
  // Boxes beyond the budget serve this frame and are not kept. Two threads may have chosen the
  // same.
  if (kept_bytes_ + chosen->bytes() <= budget_bytes_ && kept_.emplace(position, chosen).second)
    kept_bytes_ += chosen->bytes();
  return chosen;
}

int64_t ChosenBoxes::cells() const {
  int64_t cells = plan_->cells;
  const MutexLock lock(mutex_);
  for (const auto& [position, boxes] : kept_)
    cells += boxes->cells() - plan_->textures.blocks[position].cells.count();
  return cells;
}

Vec3i ChosenBoxes::firstCell(BlockPosition position) const {
  const TexturePlan& textures = plan_->textures;
  return textures.pyramid.regionOf(textures.blocks[position].name).lo;
}

}  // namespace sluice
