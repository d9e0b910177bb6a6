#include "src/library/opening/levels/side_levels.h"

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "io/zarr/levels/level_region.h"
#include "src/base/error.h"
#include "src/base/files/byte_stream.h"
#include "src/base/sources/forwarding_source.h"
#include "src/base/values/bytes.h"
#include "src/base/values/digest.h"
#include "src/library/opening/levels/coarsest_level.h"
#include "src/library/opening/thick_source.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

// Raised when the meaning of the levels changes. The second version of modes has shares.
constexpr uint32_t versionOf(Downsample how) {
  return how == Downsample::kMode ? 2 : 1;
}

// Reports damaged levels once, and has them made again at the next opening.
class DamageReport {
 public:
  DamageReport(fs::path index_file, std::function<void(const std::string& line)> announce)
      : index_file_(std::move(index_file)), announce_(std::move(announce)) {}

  // Any thread.
  void add(const Error& error) {
    // Several threads may find the damage at once; one of them tells it.
    if (is_made_.exchange(true)) return;
    std::error_code ignored;  // then the next opening finds the same damage
    // Without the index file the levels do not count as written (open()).
    fs::remove(index_file_, ignored);
    if (announce_)
      announce_(fmt::format(
          "{}; what is damaged is made of level 0 now, and all levels at the next opening",
          error.what()));
  }

 private:
  const fs::path index_file_;
  const std::function<void(const std::string& line)> announce_;
  std::atomic<bool> is_made_{false};
};

enum class Numbers { kVoxels, kSpreads };

// A level, or its spreads, whose damaged chunks are made of the finest voxels.
class MendedLevel final : public VolumeSource {
 public:
  // All must outlive it.
  MendedLevel(VolumeSource& level, Numbers numbers, const LevelShape& shape, Downsample how,
              VolumeSource& finest, int64_t finest_time, DamageReport& damage)
      : level_(level),
        numbers_(numbers),
        shape_(shape),
        how_(how),
        finest_(finest),
        finest_time_(finest_time),
        damage_(damage) {}

  const VolumeLayout& layout() const override { return level_.layout(); }
  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    try {
      level_.readRegion(time, box, out);
    } catch (const Error& error) {
      damage_.add(error);
      // Voxels and spreads are asked for separately, so only the wanted ones are made.
      if (numbers_ == Numbers::kVoxels)
        makeLevelRegion(finest_, finest_time_, shape_, how_, box, out, {});
      else
        makeLevelRegion(finest_, finest_time_, shape_, how_, box, {}, out);
    }
  }
  std::string identity() const override { return level_.identity(); }
  uint64_t heldBytesAThread() const override { return level_.heldBytesAThread(); }
  uint64_t storedBytesRead() const override { return level_.storedBytesRead(); }

 private:
  VolumeSource& level_;
  const Numbers numbers_;
  const LevelShape shape_;
  const Downsample how_;
  VolumeSource& finest_;
  const int64_t finest_time_;
  DamageReport& damage_;
};

// A source with its own levels, if it has some, and those of the store above them.
class LeveledVolume final : public ForwardingSource {
 public:
  LeveledVolume(std::unique_ptr<VolumeSource> source, int64_t time, Downsample how,
                std::unique_ptr<LevelStore> store, std::unique_ptr<DamageReport> damage)
      : ForwardingSource(std::move(source)),
        store_(std::move(store)),
        damage_(std::move(damage)),
        layout_(ForwardingSource::layout()) {
    const std::span<const CoarserLevel> own = ForwardingSource::levelsAbove();
    levels_.assign(own.begin(), own.end());
    const CoarserLevel below = own.empty() ? CoarserLevel{this, {}} : own.back();
    const auto mended = [&](VolumeSource& level, Numbers numbers, const LevelShape& shape) {
      return mended_
          .emplace_back(std::make_unique<MendedLevel>(level, numbers, shape, how, *below.source,
                                                      time, *damage_))
          .get();
    };
    for (const CoarserLevel& level : store_->levels()) {
      const Vec3d step = level.placement.scale;
      const LevelShape shape{level.source->layout().dims,
                             // Scales of levels that sluice makes are whole numbers.
                             {std::llround(step.x), std::llround(step.y), std::llround(step.z)}};
      CoarserLevel above{mended(*level.source, Numbers::kVoxels, shape),
                         placedAbove(below.placement, level.placement)};
      above.values = level.values;
      // The spread or share of an own level's voxels is not that of the finest ones.
      if (own.empty() && level.spreads != nullptr)
        above.spreads = mended(*level.spreads, Numbers::kSpreads, shape);
      levels_.push_back(above);
    }
    layout_.levels = 1 + static_cast<int64_t>(levels_.size());
  }
  const VolumeLayout& layout() const override { return layout_; }
  std::span<const CoarserLevel> levelsAbove() const override { return levels_; }
  // Pictures take most blocks from either the file or the levels: each may have half.
  void holdAtMost(uint64_t bytes) override {
    const uint64_t of_levels = ForwardingSource::heldBytesAThread() == 0 ? bytes : bytes / 2;
    ForwardingSource::holdAtMost(bytes - of_levels);
    store_->holdAtMost(of_levels);
  }
  uint64_t storedBytesRead() const override {
    return ForwardingSource::storedBytesRead() + store_->storedBytesRead();
  }

 private:
  const std::unique_ptr<LevelStore> store_;
  const std::unique_ptr<DamageReport> damage_;
  VolumeLayout layout_;  // constant after construction, as all that follows
  std::vector<std::unique_ptr<MendedLevel>> mended_;
  std::vector<CoarserLevel> levels_;
};

// The kind of levels as part of a key.
std::string kindOf(Downsample how) {
  switch (how) {
    case Downsample::kMax:
      return "maxima-";
    case Downsample::kMin:
      return "minima-";
    case Downsample::kMode:
      return "modes-";
    case Downsample::kMean:
      break;
  }
  return {};
}

IndexKey keyOf(const VolumeSource& source, int64_t time, Downsample how) {
  return {source.identity(), "levels-" + kindOf(how) + selectionOf(source.layout(), time),
          versionOf(how)};
}

// The group in a folder of indices.
fs::path storeIn(const fs::path& folder, const IndexKey& key) {
  Digest digest;
  digest.add(key.what);
  return folder / fmt::format("levels-{:016x}.zarr", digest.value());
}

// Bytes that are free where a folder is or will be; nullopt: unknown.
std::optional<uint64_t> freeBytes(fs::path folder) {
  std::error_code status;
  // The folder is made by the writer, and free space belongs to the nearest folder that exists.
  while (!fs::exists(folder, status) && folder.has_relative_path()) folder = folder.parent_path();
  const fs::space_info space = fs::space(folder, status);
  if (status) return std::nullopt;
  return space.available;
}

// Whether levels take little more than the index does, of a file that is there to stay.
bool isCheap(VolumeSource& source, Downsample how) {
  if (source.files().empty()) return false;
  const bool is_extreme = how == Downsample::kMax || how == Downsample::kMin;
  return is_extreme || (how == Downsample::kMean && bytesPerVoxel(source.layout().type) <= 2);
}

bool hasMoreVoxels(const VolumeLayout& layout, int64_t most) {
  const Vec3d dims = toDouble(layout.dims);
  return dims.x * dims.y * dims.z > static_cast<double>(most);
}

bool makes(const SideLevelsRequest& request) {
  if (request.wish == LevelsWish::kAlways) return true;
  if (request.wish != LevelsWish::kAuto) return false;
  const VolumeLayout& layout = request.source.layout();
  if (request.continues) return request.is_asked && hasMoreVoxels(layout, kMostVoxelsOfCoarsest);
  return isLarge(layout) && (request.is_asked || isCheap(request.source, request.how));
}

}  // namespace

bool isLarge(const VolumeLayout& layout) {
  return hasMoreVoxels(layout, kMostVoxelsWithoutLevels);
}

SideLevels::SideLevels(const SideLevelsRequest& request)
    : places_(request.places),
      layout_(request.source.layout()),
      name_(request.name),
      key_(keyOf(request.source, request.time, request.how)),
      time_(request.time),
      how_(request.how),
      announce_(request.announce) {
  if (request.wish == LevelsWish::kNone || places_.disabled) return;
  open();
  if (store_ != nullptr) return;
  if (makes(request))
    prepare(request);
  else
    notes_.clear();  // nobody waits for levels
}

void SideLevels::open() {
  IndexRead kept = readIndex(places_, key_);
  if (!kept.note.empty()) notes_.push_back(std::move(kept.note));
  if (!kept.blob) return;
  const fs::path folder = storeIn(kept.path.parent_path(), key_);
  try {
    uint64_t digest = 0;
    ByteReader(*kept.blob).value(digest);
    // The group may be of another pass that was killed, or changed by somebody.
    if (digest != LevelStore::digestOf(folder))
      fail("{}: differs from the levels that were written", folder.string());
    store_ = std::make_unique<LevelStore>(folder, layout_, how_);
    index_file_ = std::move(kept.path);
  } catch (const Error& error) {
    notes_.push_back(fmt::format("{}; the levels are made again", error.what()));
    damaged_ = folder;
  }
}

void SideLevels::prepare(const SideLevelsRequest& request) {
  const auto leaveOut = [&](const std::string& why) {
    notes_.push_back(fmt::format("{}: no coarser levels are made, {}", name_, why));
  };
  // News to those alone who have asked for levels.
  const auto answer = [&](const char* why) {
    if (request.is_asked) leaveOut(why);
  };
  const Vec3i stored = storedLayout(request.source).dims;
  if (std::min({stored.x, stored.y, stored.z}) < 2) return;
  if (layout_.time_steps > 1) return answer("since it has several time steps");
  if (!canMakeLevels(request.source, request.time))
    return answer("since its background is not a number");
  if (places_.written.empty())
    return answer("since there is no folder for them (--index-dir names one)");
  // The pass that makes the min-max arrays takes the rest.
  const auto plan = planLevelStore(layout_, how_, request.memory_bytes / 2, request.pool.threads());
  if (!plan) return answer("since --memory is too small to make them");
  if (plan->levels.empty()) return;
  const std::optional<uint64_t> free = freeBytes(places_.written);
  if (free && *free < plan->voxel_bytes)
    return leaveOut(
        fmt::format("since they may take {} and {} has {} left (--index-dir names "
                    "another folder, --levels none goes without)",
                    formatBytes(plan->voxel_bytes), places_.written.string(), formatBytes(*free)));
  const fs::path folder = storeIn(places_.written, key_);
  // The index file says that sluice made it, even if it no longer looks like a store.
  std::error_code ignored;  // then the writer says why
  if (folder == damaged_) fs::remove_all(folder, ignored);
  try {
    writer_ = std::make_unique<LevelStoreWriter>(request.source, request.time, folder, *plan,
                                                 request.pool, request.stop);
  } catch (const Error& error) {
    return leaveOut(fmt::format("since they cannot be kept: {} (--index-dir names another folder)",
                                error.what()));
  }
  held_bytes_ = plan->held_bytes;
  const bool is_one = plan->levels.size() == 1;
  if (request.announce)
    request.announce(fmt::format(
        "{}: makes {} coarser level{} once and keeps {} in {}, at most {} (--levels none goes "
        "without)",
        name_, plan->levels.size(), is_one ? "" : "s", is_one ? "it" : "them", folder.string(),
        formatBytes(plan->voxel_bytes)));
}

void SideLevels::discard() {
  if (writer_ != nullptr) writer_->discard();
}

void SideLevels::finish() {
  if (writer_ == nullptr) return;
  const fs::path folder = storeIn(places_.written, key_);
  const bool is_kept = writer_->finish();
  const std::string fault = writer_->fault();
  // Its files are closed before they are read.
  writer_.reset();
  held_bytes_ = 0;
  const auto lost = [&](const std::string& why) {
    notes_.push_back(
        fmt::format("{}: its coarser levels cannot be kept, level 0 is drawn: {}", name_, why));
  };
  if (!is_kept) return lost(fault);
  try {
    // The index file is written last: it vouches for the group.
    ByteWriter blob;
    blob.value(LevelStore::digestOf(folder));
    const IndexWritten written = writeIndex(places_, key_, blob.bytes);
    if (written.path.empty()) return lost(written.note);
    store_ = std::make_unique<LevelStore>(folder, layout_, how_);
    index_file_ = written.path;
  } catch (const Error& error) {
    lost(error.what());
  }
}

std::unique_ptr<VolumeSource> SideLevels::join(std::unique_ptr<VolumeSource> source) {
  if (store_ == nullptr) return source;
  return std::make_unique<LeveledVolume>(std::move(source), time_, how_, std::move(store_),
                                         std::make_unique<DamageReport>(index_file_, announce_));
}

}  // namespace sluice
