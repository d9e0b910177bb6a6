#include "src/base/threads/progress_meter.h"

#include <utility>

namespace sluice {

ProgressMeter::ProgressMeter(ProgressWatch watch, uint64_t total)
    : watch_(std::move(watch)), total_(total) {}

void ProgressMeter::add(uint64_t more) {
  done_ += more;
  if (!watch_) return;
  const MutexLock lock(mutex_);
  watch_(done_, total_);
}

}  // namespace sluice
