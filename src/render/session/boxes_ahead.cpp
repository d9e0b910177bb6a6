#include "src/render/session/boxes_ahead.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <new>
#include <utility>

#include "src/base/threads/mutex.h"

namespace sluice {
namespace {

// Blocks chosen by one task, and how many tasks are begun beyond the one that is drawn from.
constexpr size_t kBlocksAPortion = 32;
constexpr size_t kPortionsAhead = 4;

}  // namespace

struct BoxesAhead::Portion {
  std::vector<BlockPosition> blocks;  // positions in the plan; constant once begun
  size_t end = 0;                     // behind its last block in the order; constant once begun
  std::atomic<bool> is_wanted{true};
  Mutex mutex;
  Condition ended;
  bool has_ended SLUICE_GUARDED_BY(mutex) = false;
  std::vector<VisibleBoxesPtr> chosen SLUICE_GUARDED_BY(mutex);  // boxes of `blocks`, in order
  std::exception_ptr failure SLUICE_GUARDED_BY(mutex);

  void choose(const ChosenBoxes& boxes, bool may_build, const ReadPurpose& purpose) {
    std::vector<VisibleBoxesPtr> result;
    std::exception_ptr caught;
    try {
      for (const BlockPosition block : blocks)
        // A portion that nobody wants any more ends early. Its list is then too short, and nobody
        // reads it.
        if (is_wanted) result.push_back(boxes.choose(block, may_build, purpose));
    } catch (...) {
      caught = std::current_exception();
    }
    const MutexLock lock(mutex);
    chosen = std::move(result);
    failure = caught;
    has_ended = true;
    ended.notifyAll();
  }
  void wait() {
    MutexLock lock(mutex);
    while (!has_ended) ended.wait(lock);
  }
  // The boxes of the block at `index` of blocks; waits until they are chosen. Throws the failure if
  // they could not be.
  VisibleBoxesPtr take(size_t index) {
    MutexLock lock(mutex);
    while (!has_ended) ended.wait(lock);
    if (failure) std::rethrow_exception(failure);
    return chosen[index];
  }
};

BoxesAhead::BoxesAhead(ChosenBoxesPtr boxes, const DrawOrder& order, WorkerPool& pool,
                       bool may_build, const ReadPurpose& purpose)
    : boxes_(std::move(boxes)), pool_(pool), may_build_(may_build), purpose_(purpose) {
  for (const Visit& visit : order.visits)
    blocks_.insert(blocks_.end(), visit.blocks.begin(), visit.blocks.end());
}

BoxesAhead::~BoxesAhead() {
  for (const PortionPtr& portion : begun_) portion->is_wanted = false;
  // The tasks read through the session's levels, which must be at rest when the frame ends.
  for (const PortionPtr& portion : begun_) portion->wait();
}

void BoxesAhead::begin(const IsHidden& is_hidden) {
  // Hidden blocks are passed over, so that their boxes are not read for nothing.
  while (next_ < blocks_.size() && begun_.size() < kPortionsAhead) {
    auto portion = std::make_shared<Portion>();
    while (next_ < blocks_.size() && portion->blocks.size() < kBlocksAPortion) {
      const BlockPosition block = blocks_[next_++];
      if (!is_hidden(block) && boxes_->find(block) == nullptr) portion->blocks.push_back(block);
    }
    if (portion->blocks.empty()) continue;
    portion->end = next_;
    begun_.push_back(portion);
    try {
      pool_.submit([portion, boxes = boxes_, may_build = may_build_, purpose = purpose_] {
        portion->choose(*boxes, may_build, purpose);
      });
    } catch (const std::bad_alloc&) {
      begun_.pop_back();  // nobody would end it, and the destructor waits for all
      throw;
    }
  }
}

VisibleBoxesPtr BoxesAhead::take(BlockPosition position, const IsHidden& is_hidden) {
  while (blocks_[at_] != position) ++at_;
  // Portions behind the visit are over: all blocks that the frame still asks for come later.
  for (; !begun_.empty() && begun_.front()->end <= at_; begun_.pop_front()) {
    begun_.front()->is_wanted = false;
    begun_.front()->wait();
  }
  begin(is_hidden);
  if (VisibleBoxesPtr kept = boxes_->find(position)) return kept;
  if (begun_.empty()) return nullptr;
  Portion& portion = *begun_.front();
  const auto found = std::ranges::find(portion.blocks, position);
  // It was hidden when its portion was begun. The caller draws its object box.
  if (found == portion.blocks.end()) return nullptr;
  return portion.take(static_cast<size_t>(found - portion.blocks.begin()));
}

}  // namespace sluice
