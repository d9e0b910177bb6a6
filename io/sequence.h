// SequenceSource: files of one layout as the time steps of one volume.
//
// The first file is opened at once and gives the layout; the others when they are read, a bounded
// number at a time. If the first file names its channel, and no other channel so, each step has the
// channel of that name, whatever its number there. Reads run on any number of threads at once.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/files/channel_choice.h"
#include "src/base/sources/read_units.h"
#include "src/base/sources/stored_reads.h"
#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/mutex.h"

namespace sluice {

class SequenceSource final : public VolumeSource,
                             public ChanneledSource,
                             public UnitSource,
                             public StoredSource {
 public:
  // Opens the volume of one time step. `channel`: to be read in place of the one that the user
  // asked for. Called from any thread.
  using Opener = std::function<std::unique_ptr<VolumeSource>(
      const std::string& path, const std::optional<ChannelWish>& channel)>;
  static constexpr size_t kMaxOpenFiles = 8;

  // Opens steps[0]. At most `max_open_files` others stay open, more only while threads read them.
  // Requires: steps not empty. Throws Error: the first file's own, a file that is missing, a file
  // that holds several time steps itself.
  SequenceSource(std::vector<std::string> steps, Opener opener,
                 size_t max_open_files = kMaxOpenFiles);

  // The first file's layout with time_steps set; a stored range is left out, as the other files may
  // exceed it.
  const VolumeLayout& layout() const override { return layout_; }
  // Throws Error if a file's size, type, place or scaling differs from the first one's, or if it
  // has no channel of the first one's name. All steps of microscopy lie where the first one does.
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override;
  void readRegions(int64_t time, std::span<const RegionRead> regions) override;
  void expectRegion(int64_t time, const Box3& box) override;
  std::optional<Occupancy> occupancy(int64_t time) override;
  // Covers all files as they were at the opening.
  std::string identity() const override { return identity_; }
  // Names from the first file. Other steps may have them in another order.
  std::span<const std::string> channelNames() const override { return channel_names_; }
  // Looks from the first file.
  std::span<const StoredLook> channelLooks() const override { return channel_looks_; }
  uint64_t storedBytesRead() const override;
  // The first file tells them for all.
  ReadUnits readUnits() const override { return units_; }
  std::optional<StoredReads> storedReads(int64_t time, std::span<const LevelBox> boxes,
                                         uint64_t held_bytes) override;
  uint64_t heldBytesAThread() const override { return held_bytes_a_thread_; }
  // Opens each step whose files are not known, one after the other.
  std::vector<std::string> files() override;
  // Shares the bytes out among the files that stay open.
  void holdAtMost(uint64_t bytes) override;

 private:
  struct OpenFile {
    int64_t time = 0;
    std::shared_ptr<VolumeSource> source;
  };

  // Tells the states of all steps apart: of their files, or of the volumes in folders whose files
  // are not theirs alone.
  std::string identityOfSteps(VolumeSource& first) const;
  // Opens a step with the first one's channel. Requires: layout_ and channel_ are known.
  std::unique_ptr<VolumeSource> openStep(const std::string& path) const;
  // The volume of a step, opened if need be.
  std::shared_ptr<VolumeSource> at(int64_t time);
  void checkAgrees(const std::string& path, const VolumeLayout& other) const;
  void closeIdle() SLUICE_REQUIRES(mutex_);

  const std::vector<std::string> steps_;
  const Opener opener_;
  const size_t max_open_files_;
  VolumeLayout layout_;                     // constant after construction
  std::string identity_;                    // constant after construction
  std::vector<std::string> channel_names_;  // constant after construction
  std::optional<ChannelWish> channel_;      // constant after construction; for opener_
  std::vector<StoredLook> channel_looks_;   // constant after construction
  uint64_t held_bytes_a_thread_ = 0;        // constant after construction
  ReadUnits units_;                         // constant after construction

  OpenFile* find(int64_t time) SLUICE_REQUIRES(mutex_);

  mutable Mutex mutex_;
  std::list<OpenFile> open_ SLUICE_GUARDED_BY(mutex_);        // used last in front
  uint64_t closed_read_bytes_ SLUICE_GUARDED_BY(mutex_) = 0;  // from files closed since
  // Limit for each file.
  uint64_t file_held_bytes_ SLUICE_GUARDED_BY(mutex_) = UINT64_MAX;
};

}  // namespace sluice
