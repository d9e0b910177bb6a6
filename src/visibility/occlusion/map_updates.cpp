#include "src/visibility/occlusion/map_updates.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "src/base/error.h"

namespace sluice {

UpdateSchedule::UpdateSchedule(int64_t voxels, int updates)
    // The k updates come between k + 1 equal shares of the voxels.
    : voxels_(voxels), delta_(updates == 0 ? 0 : voxels / (int64_t{updates} + 1)), next_(delta_) {
  SLUICE_CHECK(voxels >= 0 && updates >= 0);
}

bool UpdateSchedule::isDueAfter(int64_t voxels) {
  drawn_ += voxels;
  // After the last voxel there is nothing left to hide.
  if (delta_ == 0 || drawn_ < next_ || drawn_ >= voxels_) return false;
  // A large box may have passed several marks: one update serves them all.
  next_ = (drawn_ / delta_ + 1) * delta_;
  ++updates_;
  return true;
}

UpdateCount::UpdateCount(const UpdateCountOptions& options)
    : options_(options),
      center_(std::clamp(options.first, options.least, options.most)),
      next_(center_),
      slots_(static_cast<size_t>(2 * options.half_window + 1)) {
  SLUICE_CHECK(options.half_window >= 0 && options.poll_every >= 1);
  SLUICE_CHECK(options.least >= 0 && options.least <= options.most);
}

void UpdateCount::finished(const UpdatePerformance& performance) {
  slot(next_) = {performance.skipped_share - options_.update_cost * performance.updates, 0, true};
  const int polled = next_;
  ++frame_;
  if (frame_ % options_.poll_every == 0) {
    for (int k = lowest(); k <= highest(); ++k) {
      // The slot of this frame is as new as can be. The others have waited for one more poll.
      if (k == polled) continue;
      ++slot(k).age;
      if (slot(k).age > options_.oldest) slot(k).valid = false;
    }
    moveToBest();
  }
  // Every nth frame tries the count that has waited longest (Li 2003, section 4.4).
  const bool polls = (frame_ + 1) % options_.poll_every == 0;
  next_ = polls ? longestNotUpdated() : center_;
}

std::optional<double> UpdateCount::performance(int updates) const {
  if (updates < lowest() || updates > highest() || !slot(updates).valid) return std::nullopt;
  return slot(updates).performance;
}

// A count that was never updated comes before the oldest.
int UpdateCount::longestNotUpdated() const {
  int longest = center_;
  const auto waited = [this](int k) { return slot(k).valid ? slot(k).age : options_.oldest + 1; };
  for (int k = lowest(); k <= highest(); ++k)
    if (inRange(k) && waited(k) > waited(longest)) longest = k;
  return longest;
}

// Acts only once the whole window is known. Of equal counts it takes the one nearest to the centre,
// so that a flat function does not drift.
void UpdateCount::moveToBest() {
  int best = center_;
  for (int k = lowest(); k <= highest(); ++k) {
    if (!inRange(k)) continue;
    if (!slot(k).valid) return;
    const double gain = slot(k).performance - slot(best).performance;
    const bool nearer = std::abs(k - center_) < std::abs(best - center_);
    if (gain > 0 || (gain == 0 && nearer)) best = k;
  }
  // Performances of counts that stay in the window are kept.
  std::vector<Slot> moved(slots_.size());
  for (int k = lowest(); k <= highest(); ++k) {
    const int at = k - (best - options_.half_window);
    if (at >= 0 && at < static_cast<int>(moved.size())) moved[static_cast<size_t>(at)] = slot(k);
  }
  slots_ = std::move(moved);
  center_ = best;
}

}  // namespace sluice
