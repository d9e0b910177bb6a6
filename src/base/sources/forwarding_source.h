// ForwardingSource: a VolumeSource that passes every call on to another one, which it owns; the
// base of sources that replace a property or two.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "src/base/sources/level_kinds.h"
#include "src/base/sources/read_units.h"
#include "src/base/sources/stored_reads.h"
#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_source.h"
#include "src/base/sources/volume_times.h"

namespace sluice {

class ForwardingSource : public VolumeSource,
                         public ChanneledSource,
                         public TimedSource,
                         public LeveledSource,
                         public LevelKinds,
                         public UnitSource,
                         public StoredSource {
 public:
  explicit ForwardingSource(std::unique_ptr<VolumeSource> source) : source_(std::move(source)) {}

  const VolumeLayout& layout() const override { return source_->layout(); }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    source_->readRegion(time, box, out);
  }
  void readRegions(int64_t time, std::span<const RegionRead> regions) override {
    source_->readRegions(time, regions);
  }
  void expectRegion(int64_t time, const Box3& box) override { source_->expectRegion(time, box); }
  std::optional<Occupancy> occupancy(int64_t time) override { return source_->occupancy(time); }
  std::string identity() const override { return source_->identity(); }
  std::span<const std::string> channelNames() const override {
    return sluice::channelNames(*source_);
  }
  std::span<const StoredLook> channelLooks() const override {
    return sluice::channelLooks(*source_);
  }
  std::optional<TimeAxis> times() const override { return timesOf(*source_); }
  std::span<const CoarserLevel> levelsAbove() const override { return coarserLevels(*source_); }
  std::span<const CoarserLevel> levelsOfKind(LevelValues values) const override {
    return sluice::levelsOfKind(*source_, values);
  }
  uint64_t storedBytesRead() const override { return source_->storedBytesRead(); }
  uint64_t heldBytesAThread() const override { return source_->heldBytesAThread(); }
  void holdAtMost(uint64_t bytes) override { source_->holdAtMost(bytes); }
  ReadUnits readUnits() const override { return sluice::readUnits(*source_); }
  PassReads passReads() const override { return source_->passReads(); }
  int distantReads() const override { return source_->distantReads(); }
  std::vector<std::string> files() override { return source_->files(); }
  std::optional<StoredReads> storedReads(int64_t time, std::span<const LevelBox> boxes,
                                         uint64_t held_bytes) override {
    return sluice::storedReads(*source_, time, boxes, held_bytes);
  }

 private:
  const std::unique_ptr<VolumeSource> source_;
};

}  // namespace sluice
