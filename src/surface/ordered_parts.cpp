#include "src/surface/ordered_parts.h"

#include <utility>

namespace sluice {

bool OrderedParts::put(size_t at, MeshPart& part, bool is_last) {
  MutexLock lock(mutex_);
  while (turn_ != at && !is_given_up_) {
    if (is_last && waiting_bytes_ + part.bytes() <= most_waiting_bytes_) {
      waiting_bytes_ += part.bytes();
      waiting_.emplace(at, std::exchange(part, {}));
      return true;
    }
    changed_.wait(lock);
  }
  if (is_given_up_) return false;
  // Nobody else passes as long as it is this piece's turn, with the lock or without.
  lock.unlock();
  file_.append(part);
  part.vertices.clear();
  part.triangles.clear();
  part.vertex_count = part.triangle_count = 0;
  lock.lock();
  if (!is_last) return true;
  for (auto next = waiting_.find(++turn_); next != waiting_.end(); next = waiting_.find(++turn_)) {
    const MeshPart waited = std::move(next->second);
    waiting_.erase(next);
    waiting_bytes_ -= waited.bytes();
    lock.unlock();
    file_.append(waited);
    lock.lock();
  }
  changed_.notifyAll();
  return true;
}

void OrderedParts::giveUp() {
  const MutexLock lock(mutex_);
  is_given_up_ = true;
  changed_.notifyAll();
}

}  // namespace sluice
