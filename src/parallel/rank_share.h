// RankShare: all that makes of a session one rank's of several: its device draws parts, its blocks
// are those that it was dealt, what it can see is what all ranks together found, and the picture is
// put together by all.
//
// The way of a frame on ranks: culled_blocks.h (each looks at tiles of the estimate, one exchange
// of what is visible) -> rank_blocks.h -> the frame's chain as ever -> part_device.h ->
// compositing.h. All ranks make the same calls in the same order. One thread, the device's.
#pragma once

#include <cstdint>
#include <memory>

#include "src/parallel/compositing.h"
#include "src/parallel/part_device.h"
#include "src/parallel/rank_blocks.h"
#include "src/render/culled_blocks.h"

namespace sluice {

// What parts of a picture of this size may take of a rank's memory: those that it draws and those
// that it gets, at the most a quarter.
uint64_t partBytes(PictureSize size, const Dealing& dealing, uint64_t memory_bytes);

class RankShare {
 public:
  // `team` and `pool` must outlive it. `part_bytes`: of memory, see partBytes().
  RankShare(Team& team, const Dealing& dealing, WorkerPool& pool, uint64_t part_bytes);

  // The rank's device from its own. Once; it must outlive the share.
  std::unique_ptr<PartDevice> deviceFrom(std::unique_ptr<Device> own);
  PartDevice& device() { return *device_; }
  // Of a series: see RankBlocks.
  void dealEachPicture(bool each) { blocks_.dealEachPicture(each); }
  // Who chooses this rank's blocks, of those that `chooser` says, null: the classification.
  BlockChooser* chooserFrom(BlockChooser* chooser);
  // Sets what culling needs so that each rank looks at its tiles.
  void shareEstimate(CullingOptions& options);

  // Of the last frame, at rank 0; elsewhere empty. Throws Error, RankFailed, Interrupted.
  Picture picture();
  const CompositingReport& report() const { return report_; }

  // `body` at rank 0, then at all others at once: for what rank 0 keeps for them in a file.
  template <class Body>
  void inTurn(const Body& body) {
    if (team_.isFirst()) body();
    team_.wait();
    if (!team_.isFirst()) body();
  }
  Team& team() { return team_; }
  const Dealing& dealing() const { return dealing_; }

 private:
  void exchangeReached(int64_t time, std::vector<bool>& reached);

  Team& team_;
  const Dealing dealing_;
  WorkerPool& pool_;
  const uint64_t part_bytes_;
  RankBlocks blocks_;
  PartDevice* device_ = nullptr;
  CompositingReport report_;
};

}  // namespace sluice
