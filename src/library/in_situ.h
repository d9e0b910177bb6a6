// A volume of which each rank of an MPI program has a part: what the ranks agree on, and how their
// failures meet. See include/sluice/in_situ.h.
#pragma once

#include <sluice/in_situ.h>

#include <memory>
#include <optional>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/stop_token.h"
#include "src/library/opening/indexed_volume.h"
#include "src/parallel/communication/team.h"
#include "src/parallel/lent_boxes.h"

namespace sluice {

struct Ranks::Impl {
  explicit Impl(std::unique_ptr<Communicator> communicator) : team(std::move(communicator)) {}
  Team team;
};
Ranks ranksOf(std::unique_ptr<Communicator> communicator);

// A volume in parts has this beside its own voxels. Constant.
struct InSitu {
  std::shared_ptr<Ranks::Impl> ranks;
  std::shared_ptr<const LentBoxes> boxes;
  bool can_look_around = false;  // all ranks have the ghosts that lit pictures need

  Team& team() const { return ranks->team; }
  // The voxels around the cells that this rank draws, as a crop takes them.
  Box3 ownVoxels() const { return boxes->voxelsFor(team().rank(), false); }
};

// Runs a call that all ranks make. A failure at one of them is one at all: they throw Error with
// the same line. A rank that was stopped throws Interrupted itself.
template <class Call>
auto together(Team& team, const Call& call) {
  std::string reason;
  try {
    auto result = call();
    team.wait();  // also for failures of others
    return result;
  } catch (const RankFailed& failed) {
    throw Error(failed.what());
  } catch (const Interrupted&) {
    team.fail("cancelled");
    throw;
  } catch (const std::exception& error) {
    reason = error.what();
  }
  throw Error(team.fail(reason).what());
}

// The part of a rank, as it was lent.
struct LentPart {
  const void* first = nullptr;
  VolumeLayout layout;  // of the whole volume
  LentBox box;
  std::optional<std::array<int64_t, 4>> strides = {};
};

// The volume of which this rank has a part, with the values of all ranks, and what they agreed on.
// All ranks call. Throws Error, Interrupted.
struct SharedVolume {
  IndexedVolume volume;
  std::shared_ptr<const InSitu> in_situ;
};
SharedVolume openShared(const LentPart& part, std::shared_ptr<Ranks::Impl> ranks,
                        const VolumeArguments& arguments, const MachineOptions& machine,
                        const IndexPass& pass);

}  // namespace sluice
