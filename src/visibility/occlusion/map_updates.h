// Schedules the updates of the opacity map in a frame, and adapts their number from frame to frame
// (Li 2003, sections 4.3 and 4.4). State machines without a clock and without GL; one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace sluice {

// Within a frame: an update is due each time another 1 / (updates + 1) of the voxels in visible
// boxes has been drawn. A box may hold more than that, so fewer updates may come about; none comes
// after the last voxel, where there is nothing left to hide.
class UpdateSchedule {
 public:
  // Requires: voxels >= 0, updates >= 0.
  UpdateSchedule(int64_t voxels, int updates);

  // To be called after a box of so many voxels was drawn. True when an update is due now.
  bool isDueAfter(int64_t voxels);
  int updates() const { return updates_; }  // updates due so far: k' of the paper

 private:
  const int64_t voxels_;
  int64_t delta_ = 0;  // DeltaVoxels; 0: never
  int64_t drawn_ = 0, next_ = 0;
  int updates_ = 0;
};

// The gain of a frame: p = v - c k', with v the share of voxels culled and clipped.
struct UpdatePerformance {
  double skipped_share = 0;  // 0 to 1
  int updates = 0;           // k': updates that took place
};

struct UpdateCountOptions {
  int first = 9;              // k at the start
  int half_window = 3;        // hw: performances of k - hw to k + hw are kept
  int poll_every = 10;        // n: frames between trials of another number
  int oldest = 14;            // polls after which a slot no longer counts
  double update_cost = 0.02;  // c
  int least = 1, most = 64;   // k stays within
};

// The number of updates that frames ask for, adapted from frame to frame.
//
// Every nth frame tries the number in the window whose performance has not been updated for the
// longest; the others use k. When all slots of the window are valid the best becomes the new centre
// and the window moves with it. Numbers outside [least, most] are no part of the window. The paper
// leaves open at what age a slot is too old; here it is two rounds of polling.
class UpdateCount {
 public:
  explicit UpdateCount(const UpdateCountOptions& options = {});

  // The number for the frame that comes.
  int next() const { return next_; }
  // Records the gain of that frame.
  void finished(const UpdatePerformance& performance);

  const UpdateCountOptions& options() const { return options_; }
  int center() const { return center_; }  // k
  // p of the last frame that used `updates`; nullopt: not in the window, never polled, or too old.
  std::optional<double> performance(int updates) const;

 private:
  struct Slot {
    double performance = 0;
    int age = 0;
    bool valid = false;
  };

  bool inRange(int updates) const { return updates >= options_.least && updates <= options_.most; }
  Slot& slot(int updates) { return slots_[static_cast<size_t>(updates - lowest())]; }
  const Slot& slot(int updates) const { return slots_[static_cast<size_t>(updates - lowest())]; }
  int lowest() const { return center_ - options_.half_window; }
  int highest() const { return center_ + options_.half_window; }
  int longestNotUpdated() const;
  void moveToBest();

  UpdateCountOptions options_;
  int center_;
  int next_;
  int frame_ = 0;            // frames finished
  std::vector<Slot> slots_;  // for k - hw to k + hw
};

}  // namespace sluice
