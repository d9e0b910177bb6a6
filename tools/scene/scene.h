// Scene: a volume opened for a command: source, index, device, session, and the transfer function
// that the options ask for. It only puts calls of the library together, and prints its warnings.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "src/library/drawing/picture_memory.h"
#include "src/library/drawing/resources.h"
#include "src/library/drawing/view_fit.h"
#include "src/library/opening/indexed_volume.h"
#include "src/parallel/rank_share.h"
#include "tools/command_line/outputs.h"
#include "tools/options/arguments.h"
#include "tools/scene/workers.h"

namespace sluice {

// Every file that a source reads, as far as it is known.
template <class Source>
std::vector<std::string> filesOf(Source& source) {
  if constexpr (requires { source.files(); })
    return source.files();
  else
    return {};
}

// Opens the volume, checks the files that the command will write against those it is read from,
// reads or builds its index, and prints its notes. Throws Error.
IndexedVolume openIndexed(const VolumeArguments& volume, const ResourceArguments& resources,
                          const IndexNeeds& needs, WorkerPool& pool,
                          const Outputs& outputs = Outputs());

// Needs of a picture with these options. A cut through levels may be opened with a stand-in
// (stand_in.h) if `finest` allows it, and with a sample (volume_sample.h) if it allows that.
enum class FinestLevel { kRead, kMayWait, kMaySample };
IndexNeeds pictureNeeds(const LookArguments& look, const FrameOptions& frame, FinestLevel finest);
// Whether pictures from these cameras of a volume with a stand-in have to wait for the index of
// the finest level: they show that level, and no limit of bytes or time stands against it.
bool mustReadFinest(const IndexedVolume& volume, const TransferFunction& transfer,
                    const FrameOptions& frame, std::span<const Camera> cameras, WorkerPool& pool);

// fitCameras() with progress, until a signal comes.
void fitCameras(std::vector<Camera>& cameras, FitChoice choice, const FitRequest& request,
                Room room, const ResourceArguments& resources, WorkerPool& pool);

// lookFor() of a composite picture.
TransferFunction transferFor(const IndexedVolume& volume, const LookArguments& look);

struct Scene {
  // `partition`: kBoxes if frames may ask for growing boxes.
  Scene(const VolumeArguments& volume, const LookArguments& look,
        const ResourceArguments& resources, Partition partition, Mode mode = Mode::kComposite,
        const Outputs& outputs = Outputs());
  // The same as one rank's of a team, which must outlive it, for pictures of this size; null:
  // alone.
  Scene(const VolumeArguments& volume, const LookArguments& look,
        const ResourceArguments& resources, const FrameOptions& frame, const Outputs& outputs,
        Team* team, FinestLevel finest = FinestLevel::kRead);

  // Chosen by this, or null by the classification; of several ranks each has its share.
  void chooseBlocksBy(BlockChooser* chooser);
  // Draws the next picture. With several ranks, all call it and rank 0 gets the picture.
  Frame frame();
  // Runs `body`, with several ranks at rank 0 first, so that the files that it keeps are there for
  // the others.
  template <class Body>
  void inTurn(const Body& body) {
    if (share)
      share->inTurn(body);
    else
      body();
  }

  // After a frame: notes the process's own memory.
  void noteMemory();
  // Keeps the ranges of finest blocks that pictures have learnt (learnt_ranges.h) for later
  // commands.
  void keepLearntRanges() const;

  Workers pool;
  IndexedVolume volume;
  uint64_t memory_bytes;
  PictureDemand pictures;   // memory demand of the scene's pictures
  uint64_t part_bytes = 0;  // part of memory_bytes for a picture, or a strip or part of it
  // Part of memory_bytes for all that is held in addition to the levels: min-max arrays, plans,
  // pictures, and of a series its opacity functions and what culling keeps.
  uint64_t beside_bytes = 0;
  uint64_t peak_anonymous_bytes = 0;  // at the calls of noteMemory()
  std::unique_ptr<RankShare> share;   // null: alone
  std::unique_ptr<Device> device;
  ChosenLook look;
  TransferFunction transfer;
  std::unique_ptr<Session> session;  // null after verify()
};

}  // namespace sluice
