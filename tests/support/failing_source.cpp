#include "tests/support/failing_source.h"

#include <stdexcept>

#include "src/base/error.h"

namespace sluice {

void FailingSource::readRegion(int64_t time, const Box3& box, std::span<std::byte> out) {
  {
    std::unique_lock lock(mutex_);
    const int64_t read = reads_++;
    if (read >= first_ && read - first_ < count_) {
      if (failure_ == Failure::kError) fail("failing source: read {} fails as asked", read);
      if (failure_ == Failure::kException) throw std::runtime_error("not an Error of ours");
      ++stalled_;
      changed_.notify_all();
      changed_.wait(lock, [&] { return released_; });
      --stalled_;
    }
  }
  source_.readRegion(time, box, out);
}

void FailingSource::release() {
  const std::lock_guard lock(mutex_);
  released_ = true;
  changed_.notify_all();
}

void FailingSource::waitUntilStalled() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return stalled_ > 0; });
}

}  // namespace sluice
