#include "io/sequence.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "io/files/file_list.h"
#include "io/named_input.h"
#include "io/synth/synth_source.h"
#include "io/web/address.h"
#include "src/base/error.h"
#include "src/base/values/digest.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

bool isOfNoFile(const std::string& step) {
  return isSynthSpec(step) || isAddress(step);
}

bool isFolder(const std::string& step) {
  std::error_code ignored;  // opening the step tells why it cannot be read
  return fs::is_directory(step, ignored);
}

// Whether a volume is all that is in the folder that it was opened from, as a store of chunks is.
bool isWholeFolder(VolumeSource& source, const std::string& step) {
  if (!isFolder(step)) return false;
  std::error_code ignored;
  const std::vector<std::string> files = source.files();
  return std::ranges::any_of(
      files, [&](const std::string& file) { return fs::equivalent(file, step, ignored); });
}

// Positions that differ by rounding in a text header are the same.
bool isClose(Vec3d a, Vec3d b, double scale) {
  constexpr double kTolerance = 1e-6;
  return length(a - b) <= kTolerance * scale;
}

// The channel that the first step reads, as the others find it; nullopt if it has no name of its
// own.
std::optional<ChannelWish> channelOfSeries(const VolumeLayout& layout,
                                           std::span<const std::string> names) {
  const auto at = static_cast<size_t>(layout.channel);
  if (at >= names.size() || names[at].empty() || std::ranges::count(names, names[at]) > 1)
    return std::nullopt;
  ChannelWish wish(std::nullopt, names[at]);
  wish.is_of_series = true;
  return wish;
}

}  // namespace

SequenceSource::SequenceSource(std::vector<std::string> steps, Opener opener, size_t max_open_files)
    : steps_(std::move(steps)),
      opener_(std::move(opener)),
      max_open_files_(std::max<size_t>(max_open_files, 1)) {
  SLUICE_CHECK(!steps_.empty());
  std::shared_ptr<VolumeSource> first = opener_(steps_[0], std::nullopt);
  layout_ = first->layout();
  checkAgrees(steps_[0], layout_);
  layout_.time_steps = static_cast<int64_t>(steps_.size());
  // The first file's range says nothing of the others.
  layout_.stored_range.reset();
  if (const auto gap = gapNote({steps_.begin(), steps_.end()})) layout_.notes.push_back(*gap);
  const std::span<const std::string> names = sluice::channelNames(*first);
  channel_names_.assign(names.begin(), names.end());
  channel_ = channelOfSeries(layout_, names);
  // The files' states alone do not tell how they are read (dims given by the user); the first
  // volume's identity does.
  identity_ = "sequence|" + identityOfSteps(*first) + "|first: " + first->identity();
  if (channel_) identity_ += "|channel called " + channel_->name;
  held_bytes_a_thread_ = first->heldBytesAThread();
  units_ = sluice::readUnits(*first);
  const std::span<const StoredLook> looks = sluice::channelLooks(*first);
  channel_looks_.assign(looks.begin(), looks.end());
  open_.push_front({0, std::move(first)});
}

std::string SequenceSource::identityOfSteps(VolumeSource& first) const {
  const bool are_stores = isWholeFolder(first, steps_[0]);
  std::vector<fs::path> files;
  Digest of_volumes, of_insides;
  bool has_volumes = false, has_insides = false;
  for (const std::string& step : steps_) {
    const InputPath path = isOfNoFile(step) ? InputPath() : splitInputPath(step);
    std::vector<fs::path> of_step;
    if (isFolder(step))
      of_step = are_stores ? std::vector<fs::path>() : listFolder(step);
    else if (!path.file.empty())
      of_step = {path.file};
    std::move(of_step.begin(), of_step.end(), std::back_inserter(files));
    // The file's state does not tell which of its data sets is read.
    of_insides.add(path.inside);
    has_insides |= !path.inside.empty();
    // The listing of a store, or of a folder of folders, tells nothing of its voxels.
    if (!of_step.empty()) continue;
    of_volumes.add(openStep(step)->identity());
    has_volumes = true;
  }
  std::string identity = files.empty() ? "" : fileIdentity(files);
  if (has_insides) identity += fmt::format("|insides {:016x}", of_insides.value());
  if (has_volumes) identity += fmt::format("|folders {:016x}", of_volumes.value());
  return identity;
}

std::unique_ptr<VolumeSource> SequenceSource::openStep(const std::string& path) const {
  if (layout_.channels > 1) return opener_(path, channel_);
  std::unique_ptr<VolumeSource> source = opener_(path, std::nullopt);
  // Single channels may have a name of their own in each step.
  if (channel_ && source->layout().channels > 1) source = opener_(path, channel_);
  return source;
}

void SequenceSource::holdAtMost(uint64_t bytes) {
  const MutexLock lock(mutex_);
  file_held_bytes_ = bytes / max_open_files_;
  for (const OpenFile& file : open_) file.source->holdAtMost(file_held_bytes_);
}

std::vector<std::string> SequenceSource::files() {
  std::vector<std::string> all;
  for (int64_t time = 0; time < layout_.time_steps; ++time)
    for (std::string& file : at(time)->files()) all.push_back(std::move(file));
  return all;
}

void SequenceSource::readRegion(int64_t time, const Box3& box, std::span<std::byte> out) {
  at(time)->readRegion(0, box, out);
}

std::optional<StoredReads> SequenceSource::storedReads(int64_t time,
                                                       std::span<const LevelBox> boxes,
                                                       uint64_t held_bytes) {
  // A file that is open has its share of the memory.
  return sluice::storedReads(*at(time), 0, boxes, held_bytes / max_open_files_);
}

void SequenceSource::readRegions(int64_t time, std::span<const RegionRead> regions) {
  at(time)->readRegions(0, regions);
}

void SequenceSource::expectRegion(int64_t time, const Box3& box) {
  at(time)->expectRegion(0, box);
}

std::optional<Occupancy> SequenceSource::occupancy(int64_t time) {
  return at(time)->occupancy(0);
}

uint64_t SequenceSource::storedBytesRead() const {
  const MutexLock lock(mutex_);
  uint64_t bytes = closed_read_bytes_;
  for (const OpenFile& file : open_) bytes += file.source->storedBytesRead();
  return bytes;
}

std::shared_ptr<VolumeSource> SequenceSource::at(int64_t time) {
  SLUICE_CHECK(time >= 0 && time < layout_.time_steps);
  {
    const MutexLock lock(mutex_);
    if (const OpenFile* const found = find(time)) return found->source;
  }
  // The file is opened without the lock: another thread may do the same, and the first to finish
  // stays.
  const std::string& path = steps_[static_cast<size_t>(time)];
  std::shared_ptr<VolumeSource> source = openStep(path);
  checkAgrees(path, source->layout());
  const MutexLock lock(mutex_);
  // Another thread was faster; what this one has read is counted.
  if (const OpenFile* const found = find(time)) {
    closed_read_bytes_ += source->storedBytesRead();
    return found->source;
  }
  if (file_held_bytes_ != UINT64_MAX) source->holdAtMost(file_held_bytes_);
  open_.push_front({time, source});
  closeIdle();
  return source;
}

SequenceSource::OpenFile* SequenceSource::find(int64_t time) {
  const auto found = std::find_if(open_.begin(), open_.end(),
                                  [time](const OpenFile& file) { return file.time == time; });
  if (found == open_.end()) return nullptr;
  open_.splice(open_.begin(), open_, found);
  return &*found;
}

void SequenceSource::closeIdle() {
  for (auto it = open_.end(); open_.size() > max_open_files_ && it != open_.begin();) {
    --it;
    // The source is in use elsewhere: its reads are not done, so its count is not final.
    if (it->source.use_count() > 1) continue;
    closed_read_bytes_ += it->source->storedBytesRead();
    it = open_.erase(it);
  }
}

void SequenceSource::checkAgrees(const std::string& path, const VolumeLayout& other) const {
  if (other.time_steps != 1)
    fail("{}: {} time steps in one file of a sequence, expected 1", path, other.time_steps);
  if (other.dims != layout_.dims || other.type != layout_.type)
    fail("{}: {} x {} x {} of {}, expected {} x {} x {} of {} as in {}; all time steps must agree",
         path, other.dims.x, other.dims.y, other.dims.z, name(other.type), layout_.dims.x,
         layout_.dims.y, layout_.dims.z, name(layout_.type), steps_[0]);
  const double scale = length(layout_.spacing);
  // A microscope's stage drifts from step to step, and its pictures are looked at as if it did not.
  const bool may_drift = layout_.frame == WorldFrame::kPictureRows;
  bool is_same_place =
      isClose(other.spacing, layout_.spacing, scale) &&
      (may_drift || isClose(other.origin, layout_.origin, scale + length(layout_.origin)));
  for (size_t a = 0; a < 3; ++a) is_same_place &= isClose(other.axes[a], layout_.axes[a], 1);
  if (!is_same_place)
    fail("{}: spacing, origin or axes differ from {}; all time steps must agree", path, steps_[0]);
  if (other.value_scale != layout_.value_scale || other.value_offset != layout_.value_offset)
    fail("{}: values are scaled by {} + {}, expected {} + {} as in {}; all time steps must agree",
         path, other.value_scale, other.value_offset, layout_.value_scale, layout_.value_offset,
         steps_[0]);
}

}  // namespace sluice
