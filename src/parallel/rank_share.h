// RankShare: turns a session into one rank's of several. Its device draws parts, its blocks are
// those that it was dealt, its visible blocks are those that all ranks together found, and all
// ranks compose the picture.
//
// The way of a frame on ranks: culled_blocks.h (each looks at tiles of the estimate, one exchange
// of the visible blocks) -> rank_blocks.h -> the frame's chain as ever -> part_device.h ->
// compositing.h. All ranks make the same calls in the same order. Used on one thread, the device's.
//
// The folder: here, how ranks share a picture. communication/ has how they reach one another.
#pragma once

#include <cstdint>
#include <memory>

#include "src/parallel/compositing.h"
#include "src/parallel/part_device.h"
#include "src/parallel/rank_blocks.h"
#include "src/render/blocks/culled_blocks.h"

namespace sluice {

// The memory of a rank for parts of a picture of this size, those that it draws and those that it
// receives; at most a quarter of `memory_bytes`. That much for a size of 0 x 0, of pictures whose
// sizes are not known yet.
uint64_t partBytes(PictureSize size, const Dealing& dealing, uint64_t memory_bytes);
// The least memory of which partBytes() leaves room for the parts of any picture of this size; 0
// for a size of 0 x 0.
uint64_t memoryOfAnyParts(PictureSize size, const Dealing& dealing);

class RankShare {
 public:
  // `team` and `pool` must outlive it. `part_bytes`: of memory, see partBytes().
  RankShare(Team& team, const Dealing& dealing, WorkerPool& pool, uint64_t part_bytes);

  // The rank's device from its own, which draws this share's frames. Once; it must outlive the
  // share.
  std::unique_ptr<PartDevice> deviceFrom(std::unique_ptr<Device> own);
  // Frames on the device are this share's from now on. If the shares of several sessions have one
  // device, each calls it before its frames.
  void drawOn(PartDevice& device);
  PartDevice& device() { return *device_; }
  // A series deals each picture for itself, see RankBlocks.
  void dealEachPicture(bool each) { blocks_.dealEachPicture(each); }
  // The chooser of this rank's blocks among those that `chooser` selects; null: the classification.
  BlockChooser* chooserFrom(BlockChooser* chooser);
  // Sets the culling options that make each rank look at its tiles.
  void shareEstimate(CullingOptions& options);

  // The picture of the last frame at rank 0; empty elsewhere. Throws Error, RankFailed,
  // Interrupted.
  Picture picture();
  const CompositingReport& report() const { return report_; }
  // The sum of all ranks' numbers. All ranks call it. Throws RankFailed, Interrupted.
  int64_t sumOverRanks(int64_t mine);

  // Runs `body` at rank 0, then at all others at once: for data that rank 0 keeps for them in a
  // file.
  template <class Body>
  void inTurn(const Body& body) {
    if (team_.isFirst()) body();
    team_.wait();
    if (!team_.isFirst()) body();
  }
  Team& team() { return team_; }
  // The dealing of the last picture.
  const Dealing& dealing() const { return blocks_.dealing(); }

 private:
  void exchangeReached(int64_t time, std::vector<bool>& reached);

  Team& team_;
  WorkerPool& pool_;
  const uint64_t part_bytes_;
  RankBlocks blocks_;
  PartDevice* device_ = nullptr;
  CompositingReport report_;
};

}  // namespace sluice
