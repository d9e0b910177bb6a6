// PicturePool: the open pictures of a stack of slices, each with its decoder at some row.
//
// A thread takes one out, uses it alone and gives it back; the ones idle longest are closed. Any
// thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "io/slices/slice_picture.h"
#include "src/base/threads/mutex.h"

namespace sluice {

class PicturePool {
 public:
  PicturePool(const std::vector<std::filesystem::path>& files, size_t max_idle)
      : files_(files), max_idle_(max_idle) {}

  std::unique_ptr<SlicePicture> take(size_t file) {
    std::shared_ptr<const PictureTables> known;
    {
      const MutexLock lock(mutex_);
      const auto found = std::find_if(idle_.begin(), idle_.end(),
                                      [&](const auto& entry) { return entry.first == file; });
      if (found != idle_.end()) {
        auto picture = std::move(found->second);
        idle_.erase(found);
        return picture;
      }
      if (const auto tables = tables_.find(files_[file]); tables != tables_.end())
        known = tables->second;
    }
    // Opened without the lock: a slow disk must not stop threads that find theirs.
    auto picture = openSlicePicture(files_[file], known);
    countRead(picture->storedBytesRead());
    // The table of a single page is read as fast as it is found here.
    if (known == nullptr && picture->format().pages > 1) {
      const MutexLock lock(mutex_);
      tables_.emplace(files_[file], picture->tables());
    }
    return picture;
  }

  void giveBack(size_t file, std::unique_ptr<SlicePicture> picture) {
    const MutexLock lock(mutex_);
    idle_.emplace_front(file, std::move(picture));
    closeBeyond();
  }

  // How many may be idle from now on.
  void setMaxIdle(size_t max_idle) {
    const MutexLock lock(mutex_);
    max_idle_ = max_idle;
    closeBeyond();
  }

  // The bytes read from all pictures, closed ones too.
  void countRead(uint64_t bytes) { read_bytes_ += bytes; }
  uint64_t storedBytesRead() const { return read_bytes_.load(); }

 private:
  void closeBeyond() SLUICE_REQUIRES(mutex_) {
    while (idle_.size() > max_idle_) idle_.pop_back();
  }

  const std::vector<std::filesystem::path>& files_;
  Mutex mutex_;
  size_t max_idle_ SLUICE_GUARDED_BY(mutex_);
  std::list<std::pair<size_t, std::unique_ptr<SlicePicture>>> idle_ SLUICE_GUARDED_BY(mutex_);
  std::map<std::filesystem::path, std::shared_ptr<const PictureTables>> tables_
      SLUICE_GUARDED_BY(mutex_);  // of files with several pages
  std::atomic<uint64_t> read_bytes_{0};
};

}  // namespace sluice
