#include "src/render/blocks/losses/lost_tally.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/render/blocks/losses/lost_surfaces.h"

namespace sluice {

void LostTally::ask(const TimeStep& step, const LookPtr& look, const Box3& crop) {
  Key key{step, look, crop};
  const MutexLock lock(mutex_);
  if (asked_ != nullptr && asked_->key == key) return;
  // Answers hold for one question alone.
  is_lost_.clear();
  std::vector<double> values;
  for (const SurfaceLevel& surface : look->table.surfaces()) values.push_back(surface.level);
  asked_ = std::make_shared<const Asked>(
      Asked{std::move(key), step.layout(), std::move(values), nullptr});
}

void LostTally::askNothing() {
  const MutexLock lock(mutex_);
  asked_.reset();
  is_lost_.clear();
}

void LostTally::expect(const VisibleBlocksPtr& visible) {
  const MutexLock lock(mutex_);
  SLUICE_CHECK(asked_ != nullptr);
  if (asked_->visible == visible) return;
  // A new object: readers that have begun keep the one that they have.
  Asked with_blocks = *asked_;
  with_blocks.visible = visible;
  asked_ = std::make_shared<const Asked>(std::move(with_blocks));
}

LostTally::AskedPtr LostTally::asked() const {
  const MutexLock lock(mutex_);
  return asked_;
}

void LostTally::note(const BlockName& name, const VolumeBlock& block) {
  if (name.level == 0) return;
  const AskedPtr asked = this->asked();
  // Before expect() it is not known which blocks are the picture's, and with which cells.
  if (asked == nullptr || asked->visible == nullptr) return;
  const std::vector<ObjectBlock>& blocks = asked->visible->blocks;
  const auto at = std::ranges::lower_bound(blocks, name, {}, &ObjectBlock::name);
  if (at != blocks.end() && at->name == name) store(asked, name, loses(*asked, *at, block));
}

bool LostTally::judge(const ObjectBlock& object, const VolumeBlock& block) {
  const AskedPtr asked = this->asked();
  SLUICE_CHECK(asked != nullptr);
  const bool is_lost = loses(*asked, object, block);
  store(asked, object.name, is_lost);
  return is_lost;
}

std::optional<bool> LostTally::known(const BlockName& name) const {
  const MutexLock lock(mutex_);
  const auto found = is_lost_.find(name);
  if (found == is_lost_.end()) return std::nullopt;
  return found->second;
}

bool LostTally::loses(const Asked& asked, const ObjectBlock& object, const VolumeBlock& block) {
  return std::ranges::any_of(asked.values, [&](double value) {
    return losesSurface(object.name, block,
                        {asked.pyramid, *asked.key.step.ranges, object.cells, value});
  });
}

// Results for surfaces that are no longer asked for are dropped.
void LostTally::store(const AskedPtr& asked, const BlockName& name, bool is_lost) {
  const MutexLock lock(mutex_);
  if (asked_ == nullptr || !(asked_->key == asked->key)) return;
  // Bounded, so that a long run does not grow. Blocks that are forgotten are judged again.
  if (is_lost_.size() >= kMostBlocks && !is_lost_.contains(name)) is_lost_.clear();
  is_lost_[name] = is_lost;
}

}  // namespace sluice
