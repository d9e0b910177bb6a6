#include "io/slices/slice_stack.h"

#include <algorithm>
#include <utility>

#include "io/files/file_list.h"
#include "io/files/level_places.h"
#include "io/files/plane_bands.h"
#include "io/slices/ome_set.h"
#include "io/slices/picture_pool.h"
#include "io/slices/slice_picture.h"
#include "src/base/error.h"
#include "src/base/sources/read_units.h"
#include "src/base/sources/region_check.h"
#include "src/base/sources/stored_reads.h"
#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_levels.h"

namespace sluice {
namespace {

class SliceStack final : public VolumeSource,
                         public ChanneledSource,
                         public TimedSource,
                         public LeveledSource,
                         public UnitSource,
                         public StoredSource {
 public:
  SliceStack(std::vector<std::filesystem::path> files, const SliceOptions& options)
      : files_(std::move(files)),
        pool_(files_, 0),
        max_open_pictures_(options.max_open_pictures),
        stop_(options.stop) {
    format_ = checkPictures();
    identity_ = fileIdentity(files_);
    describe(options);
    bands_ = bandsOf(0);
    openLevels();
    holdAtMost(options.held_bytes);
    placeLevels();
  }

  const VolumeLayout& layout() const override { return layout_; }
  std::string identity() const override { return identity_; }
  std::span<const std::string> channelNames() const override { return format_.order.channel_names; }
  std::span<const StoredLook> channelLooks() const override { return format_.order.channel_looks; }
  std::optional<TimeAxis> times() const override {
    return layout_.time_steps > 1 ? format_.order.times : std::nullopt;
  }
  std::span<const CoarserLevel> levelsAbove() const override { return levels_above_; }
  uint64_t storedBytesRead() const override { return pool_.storedBytesRead(); }
  std::vector<std::string> files() override {
    std::vector<std::string> all;
    for (const auto& file : files_) all.push_back(file.string());
    return all;
  }

  ReadUnits readUnits() const override { return {.voxels = {layout_.dims.x, layout_.dims.y, 1}}; }
  // A picture, a band that is filled and one that is copied from.
  uint64_t heldBytesAThread() const override {
    return format_.open_bytes + 2 * bands_->bandBytes();
  }
  void holdAtMost(uint64_t bytes) override {
    const Shares shares = sharesOf(bytes);
    pool_.setMaxIdle(static_cast<size_t>(std::max<uint64_t>(shares.pictures, 1)));
    bands_->holdAtMost(shares.band_bytes);
    for (const auto& level : levels_) level->holdAtMost(shares.level_bytes);
  }
  std::optional<StoredReads> storedReads(int64_t /*time*/, std::span<const LevelBox> boxes,
                                         uint64_t held_bytes) override {
    // Rows that are not compressed are read, not decoded.
    if (format_.pieces.rows == 0) return std::nullopt;
    const auto boxesOf = [&](const VolumeSource* level) {
      std::vector<Box3> found;
      for (const LevelBox& box : boxes)
        if (box.level == level) found.push_back(box.box);
      return found;
    };
    const Shares shares = sharesOf(held_bytes);
    StoredReads reads = bands_->storedReads(boxesOf(nullptr), shares.band_bytes);
    for (const auto& level : levels_)
      reads += level->bands().storedReads(boxesOf(level.get()), shares.level_bytes);
    return reads;
  }

  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    const RegionRead region{box, out};
    readRegions(time, std::span(&region, 1));
  }
  void readRegions(int64_t time, std::span<const RegionRead> regions) override {
    copy(*bands_, layout_, time, regions);
  }

 private:
  // The reduced pictures of all pages.
  class Level final : public VolumeSource {
   public:
    // `number`: from 1. The stack must outlive it.
    Level(SliceStack& stack, size_t number)
        : stack_(stack), bands_(stack.bandsOf(number)), layout_(stack.layout_) {
      const ReducedFormat& format = stack.format_.reduced[number - 1];
      layout_.dims.x = format.width;
      layout_.dims.y = format.height;
      identity_ = fmt::format("{}|level {}", stack.identity_, number);
    }
    const VolumeLayout& layout() const override { return layout_; }
    std::string identity() const override { return identity_; }
    uint64_t storedBytesRead() const override { return 0; }  // the stack counts all
    uint64_t heldBytesAThread() const override { return 2 * bands_->bandBytes(); }
    void holdAtMost(uint64_t bytes) override { bands_->holdAtMost(bytes); }
    const PlaneBands& bands() const { return *bands_; }
    void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
      const RegionRead region{box, out};
      readRegions(time, std::span(&region, 1));
    }
    void readRegions(int64_t time, std::span<const RegionRead> regions) override {
      stack_.copy(*bands_, layout_, time, regions);
    }

   private:
    SliceStack& stack_;
    const std::unique_ptr<PlaneBands> bands_;
    VolumeLayout layout_;
    std::string identity_;
  };

  struct Shares {
    uint64_t pictures = 0;  // how many stay open
    uint64_t band_bytes = 0, level_bytes = 0;
  };
  // A third for pictures, whose number counts, the rest for rows: half of it for coarser levels, if
  // there are any.
  Shares sharesOf(uint64_t bytes) const {
    const uint64_t open_bytes = std::max<uint64_t>(format_.open_bytes, 1);
    Shares shares{std::min<uint64_t>(bytes / 3 / open_bytes, max_open_pictures_)};
    const uint64_t left = bytes - std::min(bytes, shares.pictures * open_bytes);
    shares.band_bytes = levels_.empty() ? left : left / 2;
    shares.level_bytes = levels_.empty() ? 0 : left / 2 / levels_.size();
    return shares;
  }

  void copy(PlaneBands& bands, const VolumeLayout& layout, int64_t time,
            std::span<const RegionRead> regions) {
    for (const RegionRead& region : regions) checkRegion(layout, time, region.box, region.out);
    bands.copy(regions, bytesPerVoxel(layout.type), [&](int64_t z) {
      stop_.throwIfStopped();
      return is_described_ ? format_.order.plane(time, z, layout_.channel) : z;
    });
  }

  // Decoded rows of the pictures of a level; 0: of the pages themselves.
  std::unique_ptr<PlaneBands> bandsOf(size_t level) {
    const ReducedFormat size =
        level == 0 ? ReducedFormat{format_.width, format_.height, format_.unit_rows, format_.pieces}
                   : format_.reduced[level - 1];
    const int64_t row_bytes = size.width * static_cast<int64_t>(bytesPerVoxel(format_.type));
    const PlaneBands::Shape shape{
        .height = size.height,
        .row_bytes = row_bytes,
        .band_rows = PlaneBands::usualBandRows(size.height, row_bytes, size.unit_rows),
        .unit_rows = std::max<int64_t>(size.pieces.rows, 1),
        .units_across = size.pieces.across};
    return std::make_unique<PlaneBands>(
        shape,
        [this, level](int64_t plane, int64_t first, int64_t count, std::span<std::byte> rows) {
          decode(plane, level, first, count, rows);
        });
  }

  void openLevels() {
    const LevelClaim finest{layout_.dims, {}, {}};
    for (size_t number = 1; number <= format_.reduced.size(); ++number) {
      auto level = std::make_unique<Level>(*this, number);
      const LevelClaim claim{level->layout().dims, {}, {}};
      if (const std::string fault = faultOfLevel(finest, claim); !fault.empty()) {
        layout_.notes.push_back(
            fmt::format("{}: level {} is left out: {}", files_[0].string(), number, fault));
        continue;
      }
      levels_above_.push_back(
          {.source = level.get(), .placement = {levelFactor(finest, claim), {}}});
      levels_.push_back(std::move(level));
    }
    layout_.levels = 1 + static_cast<int64_t>(levels_.size());
  }
  void placeLevels() {
    if (!levels_above_.empty())
      layout_.notes.push_back(files_[0].string() + ": " + findOrigin(*this, levels_above_));
  }

  void describe(const SliceOptions& options) {
    const PageOrder& order = format_.order;
    const std::string first = files_[0].string();
    layout_.dims = {format_.width, format_.height,
                    is_described_ ? order.slices : static_cast<int64_t>(files_.size())};
    layout_.type = format_.type;
    layout_.name = files_[0].filename().string();
    layout_.path = first;
    layout_.frame = WorldFrame::kPictureRows;
    layout_.spacing = options.spacing.value_or(order.spacing);
    layout_.origin = order.origin;
    if (!options.spacing) {
      layout_.unit = order.unit;
      if (!order.spacing_fault.empty())
        layout_.notes.push_back(fmt::format("{}: {}", first, order.spacing_fault));
    } else {
      // The place stays so many voxels away, in the unit of the spacing that was given.
      for (int a = 0; a < 3; ++a)
        layout_.origin[a] = order.origin[a] * (layout_.spacing[a] / order.spacing[a]);
    }
    layout_.tells_place = order.tells_place;
    if (!order.place_fault.empty())
      layout_.place_fault = fmt::format("{}: {}", first, order.place_fault);
    for (const std::string& note : format_.notes)
      layout_.notes.push_back(fmt::format("{}: {}", first, note));
    for (const std::string& note : order.notes)
      layout_.notes.push_back(fmt::format("{}: {}", first, note));
    layout_.value_scale = format_.value_scale;
    layout_.value_offset = format_.value_offset;
    if (is_described_) {
      layout_.time_steps = order.frames;
      layout_.channels = order.channels;
    }
    chooseChannel(first, options.channel, format_.order.channel_names, layout_);
    if (layout_.channels > 1) identity_ += fmt::format("|channel {}", layout_.channel);
    if (!format_.blanked.empty())
      identity_ += fmt::format("|without {}", fmt::join(format_.blanked, ", "));
    if (const auto gap = gapNote(files_); gap && !is_described_) layout_.notes.push_back(*gap);
  }

  void decode(int64_t plane, size_t level, int64_t first, int64_t count,
              std::span<std::byte> rows) {
    const PagePlace place =
        is_described_ ? format_.order.place(plane) : PagePlace{static_cast<uint32_t>(plane), 0};
    auto picture = pool_.take(place.file);
    const uint64_t read_before = picture->storedBytesRead();
    // If it throws, the picture is closed with its decoder's broken state and not given back.
    picture->readRows(place.page, level, first, count, rows);
    pool_.countRead(picture->storedBytesRead() - read_before);
    pool_.giveBack(place.file, std::move(picture));
  }

  // The files of the set that the first one belongs to take the place of those that were given, if
  // these are all of the set.
  void findSet(PictureFormat& format) {
    is_described_ = files_.size() == 1;
    PageOrder order = orderWithCompanion(files_[0], format.order, format.pages);
    if (order.files.empty()) {
      if (is_described_) format.order = std::move(order);
      return;
    }
    // If one of them is none of the set, all are slices, as they were given.
    for (const auto& file : files_)
      if (std::find(order.files.begin(), order.files.end(), file.filename()) == order.files.end())
        return;
    files_ = filesOfSet(files_[0], order);
    format.order = std::move(order);
    is_described_ = true;
  }

  // The number of pages that each file must have at least.
  std::vector<int64_t> wantedPages(const PageOrder& order) const {
    std::vector<int64_t> pages(files_.size(), 1);
    if (!is_described_) return pages;
    for (const PagePlace& place : order.places)
      pages[place.file] = std::max(pages[place.file], place.page + 1);
    return pages;
  }

  // Opens each file once, for its header alone; the first one twice if it is not the only one.
  PictureFormat checkPictures() {
    PictureFormat first = pool_.take(0)->format();
    // Behind others if it is a later one of its set.
    const std::string given = files_[0].string();
    findSet(first);
    if (files_.size() == 1) return first;
    const std::vector<int64_t> wanted = wantedPages(first.order);
    for (size_t i = 0; i < files_.size(); ++i) {
      stop_.throwIfStopped();
      const auto picture = pool_.take(i);
      const PictureFormat& format = picture->format();
      first.open_bytes = std::max(first.open_bytes, format.open_bytes);
      if (!is_described_ && format.pages != 1)
        fail(
            "{}: {} pages among {} files of a stack, expected one per file; give a multi-page file "
            "by itself",
            files_[i].string(), format.pages, files_.size());
      if (is_described_ && format.pages < wanted[i])
        fail(
            "{}: {} pages, but the OME description of its set names page {}; it was cut short or "
            "replaced",
            files_[i].string(), format.pages, wanted[i]);
      if (format.width != first.width || format.height != first.height || format.type != first.type)
        fail("{}: {} x {} of {}, expected {} x {} of {} as in {}; all slices must agree",
             files_[i].string(), format.width, format.height, name(format.type), first.width,
             first.height, name(first.type), given);
      if (format.value_scale != first.value_scale || format.value_offset != first.value_offset)
        fail("{}: values are scaled by {} + {}, expected {} + {} as in {}; all slices must agree",
             files_[i].string(), format.value_scale, format.value_offset, first.value_scale,
             first.value_offset, given);
      // A level needs all slices.
      if (format.reduced != first.reduced) first.reduced.clear();
    }
    return first;
  }

  std::vector<std::filesystem::path> files_;  // constant after construction, as all but the pool
  PicturePool pool_;
  const size_t max_open_pictures_;
  const StopToken stop_;
  // The order of planes is that of a description, in one file or a set; otherwise each file is a
  // slice.
  bool is_described_ = false;
  PictureFormat format_;
  VolumeLayout layout_;
  std::string identity_;
  std::unique_ptr<PlaneBands> bands_;
  std::vector<std::unique_ptr<Level>> levels_;
  std::vector<CoarserLevel> levels_above_;
};

// Pieces of one size without a header are most likely raw slices.
[[noreturn]] void failWithoutSlices(const std::filesystem::path& folder) {
  std::optional<uint64_t> bytes;
  bool same = true;
  const auto files = listFolder(folder);
  for (const auto& file : files) {
    std::error_code unknown;
    const uint64_t size = std::filesystem::file_size(file, unknown);
    same = same && !unknown && (!bytes || *bytes == size);
    bytes = size;
  }
  if (files.size() > 1 && same && bytes.value_or(0) > 0)
    fail(
        "{}: the folder has no .png or .tif slices, but {} files of {} bytes each; if they are raw "
        "slices, give --dims X,Y,{} and --type T, where X x Y voxels of the type have {} bytes",
        folder.string(), files.size(), *bytes, files.size(), *bytes);
  if (files.empty()) fail("{}: the folder has no slices, it is empty", folder.string());
  // Many keep the steps of a series in a folder of their own.
  fail(
      "{}: the folder has no slices, expected .png, .tif or .tiff files, found {}; give one file, "
      "or "
      "the files of a time series as a pattern with # for each digit",
      folder.string(), files.front().filename().string());
}

}  // namespace

std::unique_ptr<VolumeSource> openSlices(const std::vector<std::filesystem::path>& files,
                                         const SliceOptions& options) {
  if (files.empty()) fail("a stack of slices needs at least one file");
  return std::make_unique<SliceStack>(files, options);
}

std::unique_ptr<VolumeSource> openSliceFolder(const std::filesystem::path& folder,
                                              const SliceOptions& options) {
  std::vector<std::filesystem::path> pngs, tiffs;
  for (const auto& file : listFolder(folder)) {
    const std::string extension = lowerExtension(file);
    if (extension == ".png") pngs.push_back(file);
    if (extension == ".tif" || extension == ".tiff") tiffs.push_back(file);
  }
  if (pngs.empty() && tiffs.empty()) failWithoutSlices(folder);
  if (!pngs.empty() && !tiffs.empty())
    fail(
        "{}: the folder has {} PNG and {} TIFF files, expected one kind; give a pattern such as "
        "'{}/*.png'",
        folder.string(), pngs.size(), tiffs.size(), folder.string());
  const auto& slices = pngs.empty() ? tiffs : pngs;
  requireOneSeries(folder.string(), slices);
  return openSlices(slices, options);
}

}  // namespace sluice
