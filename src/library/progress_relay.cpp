#include "src/library/progress_relay.h"

namespace sluice {

void ProgressTeller::tell(Progress::Stage stage, uint64_t done, uint64_t total) {
  stop().throwIfStopped();
  if (!progress_) return;
  const MutexLock lock(mutex_);
  progress_({stage, done, total});
}

ProgressWatch ProgressTeller::watch(Progress::Stage stage) {
  return [this, stage](uint64_t done, uint64_t total) { tell(stage, done, total); };
}

void ProgressRelay::tell(Progress::Stage stage, uint64_t done, uint64_t total) {
  const MutexLock lock(mutex_);
  if (teller_ != nullptr) teller_->tell(stage, done, total);
}

ProgressRelay::Call::Call(ProgressRelay& relay, ProgressTeller& teller)
    : relay_(relay), teller_(teller) {
  const MutexLock lock(relay_.mutex_);
  relay_.teller_ = &teller_;
}

ProgressRelay::Call::~Call() {
  const MutexLock lock(relay_.mutex_);
  if (relay_.teller_ == &teller_) relay_.teller_ = nullptr;
}

}  // namespace sluice
