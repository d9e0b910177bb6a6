#include "io/slice_stack.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <list>
#include <map>
#include <mutex>
#include <utility>

#include "io/file_list.h"
#include "io/slice_picture.h"
#include "src/base/error.h"
#include "src/base/interrupt.h"

namespace sluice {
namespace {

constexpr int64_t kBandBytes = int64_t{512} << 10;
constexpr int64_t kMaxUnitBytes = int64_t{8} << 20;

// Pictures that are open and idle, each where its decoder stands. A thread takes one out, uses it
// alone and gives it back; the ones idle longest are closed.
class PicturePool {
 public:
  PicturePool(const std::vector<std::filesystem::path>& files, size_t max_idle)
      : files_(files), max_idle_(max_idle) {}

  std::unique_ptr<SlicePicture> take(size_t file) {
    {
      const std::lock_guard lock(mutex_);
      const auto found = std::find_if(idle_.begin(), idle_.end(),
                                      [&](const auto& entry) { return entry.first == file; });
      if (found != idle_.end()) {
        auto picture = std::move(found->second);
        idle_.erase(found);
        return picture;
      }
    }
    auto picture = openSlicePicture(files_[file]);
    countRead(picture->storedBytesRead());
    return picture;
  }

  void giveBack(size_t file, std::unique_ptr<SlicePicture> picture) {
    const std::lock_guard lock(mutex_);
    idle_.emplace_front(file, std::move(picture));
    if (idle_.size() > max_idle_) idle_.pop_back();
  }

  // The bytes read from all pictures, closed ones too.
  void countRead(uint64_t bytes) { read_bytes_ += bytes; }
  uint64_t storedBytesRead() const { return read_bytes_.load(); }

 private:
  const std::vector<std::filesystem::path>& files_;
  const size_t max_idle_;
  std::mutex mutex_;
  std::list<std::pair<size_t, std::unique_ptr<SlicePicture>>> idle_;  // guarded by mutex_
  std::atomic<uint64_t> read_bytes_{0};
};

// Decoded rows [band * band_rows, ...) of a slice. Whoever comes first fills it.
struct Band {
  std::mutex mutex;
  std::vector<std::byte> rows;  // guarded by mutex; empty until filled
};

// The bands used last, up to a number of bytes.
class BandCache {
 public:
  using Key = std::pair<int64_t, int64_t>;  // slice, band

  BandCache(uint64_t capacity_bytes, uint64_t band_bytes)
      : max_bands_(std::max<uint64_t>(capacity_bytes / band_bytes, 1)) {}

  std::shared_ptr<Band> find(Key key) {
    const std::lock_guard lock(mutex_);
    const auto found = places_.find(key);
    if (found != places_.end()) {
      order_.splice(order_.begin(), order_, found->second);
      return found->second->second;
    }
    order_.emplace_front(key, std::make_shared<Band>());
    places_[key] = order_.begin();
    if (order_.size() > max_bands_) {
      places_.erase(order_.back().first);
      order_.pop_back();
    }
    return order_.front().second;
  }

 private:
  using Order = std::list<std::pair<Key, std::shared_ptr<Band>>>;
  const uint64_t max_bands_;
  std::mutex mutex_;
  Order order_;                            // guarded by mutex_; used last in front
  std::map<Key, Order::iterator> places_;  // guarded by mutex_
};

class SliceStack final : public VolumeSource {
 public:
  SliceStack(std::vector<std::filesystem::path> files, const SliceOptions& options)
      : files_(std::move(files)), pool_(files_, options.max_open_pictures) {
    PictureFormat format = checkPictures();
    layout_.dims = {format.width, format.height,
                    files_.size() == 1 ? format.pages : static_cast<int64_t>(files_.size())};
    layout_.type = format.type;
    if (options.spacing) layout_.spacing = *options.spacing;
    layout_.name = files_[0].filename().string();
    identity_ = fileIdentity(files_);

    row_bytes_ = format.width * static_cast<int64_t>(bytesPerVoxel(format.type));
    const int64_t unit_rows = std::clamp<int64_t>(format.unit_rows, 1, format.height);
    const int64_t unit = unit_rows * row_bytes_ <= kMaxUnitBytes ? unit_rows : 1;
    band_rows_ = std::max<int64_t>(kBandBytes / row_bytes_ / unit, 1) * unit;
    band_rows_ = std::min(band_rows_, format.height);
    cache_.emplace(options.cache_bytes, static_cast<uint64_t>(band_rows_ * row_bytes_));
  }

  const VolumeLayout& layout() const override { return layout_; }
  std::string identity() const override { return identity_; }
  uint64_t storedBytesRead() const override { return pool_.storedBytesRead(); }

  void readRegion(int64_t time, const Box3& box, std::span<std::byte> out) override {
    const auto voxel_bytes = static_cast<int64_t>(bytesPerVoxel(layout_.type));
    SLUICE_CHECK_EQ(time, 0);
    SLUICE_CHECK(!box.empty() && boxOf(layout_.dims).contains(box));
    SLUICE_CHECK_EQ(out.size(), static_cast<size_t>(box.count() * voxel_bytes));
    const size_t part_bytes = static_cast<size_t>(box.size().x * voxel_bytes);
    std::byte* to = out.data();
    for (int64_t z = box.lo.z; z < box.hi.z; ++z) {
      throwIfInterrupted();
      for (int64_t y = box.lo.y; y < box.hi.y;) {
        const int64_t band = y / band_rows_;
        const int64_t band_end = std::min((band + 1) * band_rows_, box.hi.y);
        const auto entry = cache_->find({z, band});
        const std::lock_guard lock(entry->mutex);
        if (entry->rows.empty()) fill(*entry, z, band);
        for (; y < band_end; ++y, to += part_bytes)
          std::memcpy(
              to,
              entry->rows.data() + (y - band * band_rows_) * row_bytes_ + box.lo.x * voxel_bytes,
              part_bytes);
      }
    }
  }

 private:
  void fill(Band& band, int64_t z, int64_t index) {
    const int64_t first = index * band_rows_;
    const int64_t count = std::min(band_rows_, layout_.dims.y - first);
    const bool is_page = files_.size() == 1;
    const size_t file = is_page ? 0 : static_cast<size_t>(z);
    auto picture = pool_.take(file);
    std::vector<std::byte> rows(static_cast<size_t>(count * row_bytes_));
    const uint64_t read_before = picture->storedBytesRead();
    picture->readRows(is_page ? z : 0, first, count, rows);
    pool_.countRead(picture->storedBytesRead() - read_before);
    pool_.giveBack(file, std::move(picture));
    band.rows = std::move(rows);
  }

  // Opens each file once, for its header alone.
  PictureFormat checkPictures() {
    PictureFormat first;
    for (size_t i = 0; i < files_.size(); ++i) {
      throwIfInterrupted();
      auto picture = pool_.take(i);
      const PictureFormat format = picture->format();
      pool_.giveBack(i, std::move(picture));
      if (i == 0) first = format;
      if (files_.size() > 1 && format.pages != 1)
        fail(
            "{}: {} pages among {} files of a stack, expected one a file; give a multi-page file "
            "alone",
            files_[i].string(), format.pages, files_.size());
      if (format.width != first.width || format.height != first.height || format.type != first.type)
        fail("{}: {} x {} of {}, expected {} x {} of {} as in {}; all slices must agree",
             files_[i].string(), format.width, format.height, name(format.type), first.width,
             first.height, name(first.type), files_[0].string());
    }
    return first;
  }

  const std::vector<std::filesystem::path> files_;
  PicturePool pool_;
  VolumeLayout layout_;
  std::string identity_;
  int64_t row_bytes_ = 0;
  int64_t band_rows_ = 0;
  std::optional<BandCache> cache_;  // constant after construction
};

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
  if (pngs.empty() && tiffs.empty())
    fail("{}: the folder has no slices, expected .png, .tif or .tiff files", folder.string());
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
