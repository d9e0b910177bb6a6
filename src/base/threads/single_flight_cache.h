// SingleFlightCache: values under a budget of bytes, each loaded once however many threads want it.
//
// The first thread that wants a key publishes an entry and loads outside the lock; the others find
// it and wait. A failure is kept in the entry: every thread that waited gets it, and the next call
// loads again. Entries that nobody wants or holds leave in order of their last use. Levels 2 and 3
// and the caches of decoded chunks, bands and boxes account with this; each adds what a load is. To
// tell a redundant load, the cache remembers at least the last `remembered` keys; the number is
// bounded, so that a long run does not grow.
//
// get() does all of it for owners whose loads are one function. The others lock `mutex` and take
// the steps themselves:
//   join() or publish(), then load with the lock given up, then finish() or fail(), then take().
// Every published entry must be brought to finish() or fail(), also when memory runs out in
// between; these two never throw. State of the owner that goes with the entries may be guarded by
// `mutex` too. Any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <functional>
#include <list>
#include <memory>
#include <unordered_map>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/counters.h"
#include "src/base/threads/mutex.h"

namespace sluice {

// The note of an owner that keeps nothing with an entry.
struct NoNote {};

// Whether a value that someone outside holds stays resident and counted, or may leave the cache and
// then belongs to the holder alone.
enum class Held { kStays, kMayLeave };

// Whether a thread waits for the load of another one, or leaves without the value.
enum class IfLoading { kWait, kLeave };

template <class Key, class T, class Hash = std::hash<Key>, class Note = NoNote>
class SingleFlightCache {
 public:
  using Value = std::shared_ptr<T>;
  struct Entry;
  using EntryPtr = std::shared_ptr<Entry>;

  // `key` is constant, the rest is guarded by the cache's mutex.
  struct Entry {
    explicit Entry(Key of) : key(std::move(of)) {}
    const Key key;
    enum class State { kLoading, kResident, kGone } state = State::kLoading;
    uint64_t bytes = 0;  // taken from the budget: set aside while loading, then the value's bytes
    uint64_t returns_from = 0;   // see publish()
    int64_t wanted_by = 0;       // joined or published, and neither taken nor let go
    Value value;                 // once loaded
    std::exception_ptr failure;  // why it was not
    Note note;                   // the owner's
    typename std::list<EntryPtr>::iterator place;  // in loading_ or recent_
  };

  static constexpr size_t kRemembered = size_t{1} << 18;

  SingleFlightCache(uint64_t budget_bytes, Held held, size_t remembered = kRemembered)
      : held_(held), remembered_(remembered) {
    counters_.budget_bytes = budget_bytes;
  }
  SingleFlightCache(const SingleFlightCache&) = delete;
  SingleFlightCache& operator=(const SingleFlightCache&) = delete;

  mutable Mutex mutex;
  Condition changed;  // an entry came to its end; owners may notify it of more

  struct Loaded {
    Value value;
    uint64_t bytes = 0;
    bool keep = true;  // false: only for the threads that wait for it now
  };
  // The value of `key`. If it is neither resident nor being loaded, load() makes it (a Loaded) on
  // this thread and without the lock, while `bytes` of the budget are set aside. The budget is
  // exceeded if nothing can be evicted. Every thread that waited gets what load() throws. With
  // kLeave, null is returned and nothing counted if another thread is loading it.
  template <class Load>
  Value get(const Key& key, uint64_t bytes, Load&& load, IfLoading if_loading = IfLoading::kWait)
      SLUICE_EXCLUDES(mutex);

  // The steps of get(), for owners that take them themselves.

  // The entry of a key that is resident (a hit, now the most recently used one) or being loaded (a
  // miss that coalesces; a hit if it returns); wanted once more. Otherwise returns null and counts
  // nothing.
  EntryPtr join(const Key& key) SLUICE_REQUIRES(mutex);
  // The same without counting and wanting.
  EntryPtr find(const Key& key) const SLUICE_REQUIRES(mutex);
  // A new entry, wanted once, found from now on; `bytes` are set aside, room or not. A miss; or a
  // hit, when it `returns_from` a smaller form that the owner keeps under the same budget (bytes of
  // that form). Throws std::bad_alloc, and nothing has changed. Requires: !find(key).
  EntryPtr publish(const Key& key, uint64_t bytes, uint64_t returns_from = 0)
      SLUICE_REQUIRES(mutex);
  // The value is there and takes `bytes`. Returns whether its key had been resident before.
  bool finish(const EntryPtr& entry, Value value, uint64_t bytes) noexcept SLUICE_REQUIRES(mutex);
  // It will not be there. A value given here goes to the waiting threads alone.
  void fail(const EntryPtr& entry, const std::exception_ptr& why, Value value = nullptr) noexcept
      SLUICE_REQUIRES(mutex);
  // A loading entry that no one shall join any more.
  void hide(const EntryPtr& entry) noexcept SLUICE_REQUIRES(mutex);
  // Waits for the end of the load, wants the entry once less, returns the value or throws the
  // failure.
  Value take(MutexLock& lock, const EntryPtr& entry) SLUICE_REQUIRES(mutex);
  static void letGo(const EntryPtr& entry) { --entry->wanted_by; }

  // The least recently used entry that may go, of those that suit; null when there is none.
  template <class Suits>
  EntryPtr coldest(Suits suits) const SLUICE_REQUIRES(mutex);
  EntryPtr coldest() const SLUICE_REQUIRES(mutex) {
    return coldest([](const Key& /*key*/) { return true; });
  }
  bool mayGo(const Entry& entry) const {
    return entry.wanted_by == 0 && (held_ == Held::kMayLeave || entry.value.use_count() == 1);
  }
  void evict(EntryPtr entry) SLUICE_REQUIRES(mutex);
  // Evicts the coldest until `bytes` more would fit; false when they do not even so.
  bool makeRoom(uint64_t bytes) SLUICE_REQUIRES(mutex);
  // A resident entry that goes on, compressed to `bytes`, with its owner.
  void pack(EntryPtr entry, uint64_t bytes) SLUICE_REQUIRES(mutex);
  void countPackedEviction(uint64_t bytes) SLUICE_REQUIRES(mutex) {
    counters_.countEviction(bytes);
  }
  // A miss for which there is no room.
  void countNoRoom() SLUICE_REQUIRES(mutex) { counters_.countMiss(), counters_.countFailure(); }
  void countHit() SLUICE_REQUIRES(mutex) { counters_.countHit(); }
  void countDecoded(uint64_t bytes) SLUICE_REQUIRES(mutex) { counters_.decoded_bytes += bytes; }

  // Bytes set aside for entries that are being loaded.
  uint64_t loadingBytes() const SLUICE_REQUIRES(mutex) { return loading_bytes_; }
  // Bytes that are resident, packed, or set aside for loading.
  uint64_t takenBytes() const SLUICE_REQUIRES(mutex) {
    return counters_.current_bytes + loading_bytes_;
  }
  uint64_t budgetBytes() const SLUICE_REQUIRES(mutex) { return counters_.budget_bytes; }

  // Applies at once: entries that may go do, until the rest fits.
  void setBudget(uint64_t budget_bytes) SLUICE_EXCLUDES(mutex) {
    const MutexLock lock(mutex);
    counters_.budget_bytes = budget_bytes;
    makeRoom(0);
  }
  CacheCounters counters() const SLUICE_EXCLUDES(mutex) {
    const MutexLock lock(mutex);
    return counters_;
  }
  void resetCounters() SLUICE_EXCLUDES(mutex) {
    const MutexLock lock(mutex);
    counters_.reset();
  }

 private:
  using Seen = std::unordered_map<Key, bool, Hash>;

  // Makes a place for the key among those seen, with what is known about it.
  void remember(const Key& key) SLUICE_REQUIRES(mutex);
  // Notes that the key is resident now; whether it had been before.
  bool noteResident(const Key& key) noexcept SLUICE_REQUIRES(mutex);

  const Held held_;
  const size_t remembered_;
  std::list<EntryPtr> recent_ SLUICE_GUARDED_BY(mutex);  // resident, most recently used first
  std::list<EntryPtr> loading_ SLUICE_GUARDED_BY(mutex);
  std::unordered_map<Key, EntryPtr, Hash> entries_
      SLUICE_GUARDED_BY(mutex);  // entries of both kinds
  // Keys that were published, and whether one was resident: the latest ones, and those before.
  Seen seen_ SLUICE_GUARDED_BY(mutex), seen_before_ SLUICE_GUARDED_BY(mutex);
  uint64_t loading_bytes_ SLUICE_GUARDED_BY(mutex) = 0;
  CacheCounters counters_ SLUICE_GUARDED_BY(mutex);
};

template <class Key, class T, class Hash, class Note>
template <class Load>
auto SingleFlightCache<Key, T, Hash, Note>::get(const Key& key, uint64_t bytes, Load&& load,
                                                IfLoading if_loading) -> Value {
  MutexLock lock(mutex);
  if (if_loading == IfLoading::kLeave) {
    const EntryPtr entry = find(key);
    if (entry != nullptr && entry->state == Entry::State::kLoading) return nullptr;
  }
  if (const EntryPtr entry = join(key)) return take(lock, entry);
  makeRoom(bytes);
  const EntryPtr entry = publish(key, bytes);
  lock.unlock();
  Loaded loaded;
  std::exception_ptr failure;
  try {
    loaded = load();
  } catch (...) {
    failure = std::current_exception();
  }
  lock.lock();
  if (failure || !loaded.keep) {
    fail(entry, failure, std::move(loaded.value));
  } else {
    makeRoom(loaded.bytes - std::min(loaded.bytes, bytes));
    finish(entry, std::move(loaded.value), loaded.bytes);
  }
  return take(lock, entry);
}

template <class Key, class T, class Hash, class Note>
void SingleFlightCache<Key, T, Hash, Note>::remember(const Key& key) {
  if (seen_.size() >= remembered_) seen_before_ = std::exchange(seen_, {});
  const auto before = seen_before_.find(key);
  seen_.try_emplace(key, before != seen_before_.end() && before->second);
}

template <class Key, class T, class Hash, class Note>
bool SingleFlightCache<Key, T, Hash, Note>::noteResident(const Key& key) noexcept {
  auto found = seen_.find(key);
  if (found == seen_.end()) {  // others came meanwhile
    found = seen_before_.find(key);
    if (found == seen_before_.end()) return false;
  }
  return std::exchange(found->second, true);
}

template <class Key, class T, class Hash, class Note>
auto SingleFlightCache<Key, T, Hash, Note>::find(const Key& key) const -> EntryPtr {
  const auto found = entries_.find(key);
  return found == entries_.end() ? nullptr : found->second;
}

template <class Key, class T, class Hash, class Note>
auto SingleFlightCache<Key, T, Hash, Note>::join(const Key& key) -> EntryPtr {
  EntryPtr entry = find(key);
  if (entry == nullptr) return nullptr;
  ++entry->wanted_by;
  if (entry->state == Entry::State::kResident) {
    counters_.countHit();
    recent_.splice(recent_.begin(), recent_, entry->place);
  } else if (entry->returns_from > 0) {
    counters_.countHit();
  } else {
    counters_.countMiss();
    counters_.countCoalesced();
  }
  return entry;
}

template <class Key, class T, class Hash, class Note>
auto SingleFlightCache<Key, T, Hash, Note>::publish(const Key& key, uint64_t bytes,
                                                    uint64_t returns_from) -> EntryPtr {
  // All memory that the entry takes until its end is taken now: finish() and fail() find it there.
  auto entry = std::make_shared<Entry>(key);
  remember(key);
  loading_.push_front(entry);
  entry->place = loading_.begin();
  try {
    const bool is_new = entries_.emplace(key, entry).second;
    SLUICE_CHECK(is_new);
  } catch (...) {
    loading_.pop_front();
    throw;
  }
  entry->bytes = bytes;
  entry->returns_from = returns_from;
  entry->wanted_by = 1;
  loading_bytes_ += bytes;
  if (returns_from > 0)
    counters_.countHit();
  else
    counters_.countMiss();
  return entry;
}

template <class Key, class T, class Hash, class Note>
bool SingleFlightCache<Key, T, Hash, Note>::finish(const EntryPtr& entry, Value value,
                                                   uint64_t bytes) noexcept {
  loading_bytes_ -= std::exchange(entry->bytes, bytes);
  entry->value = std::move(value);
  entry->state = Entry::State::kResident;
  recent_.splice(recent_.begin(), loading_, entry->place);
  const bool was_here_before = noteResident(entry->key);
  if (const uint64_t from = std::exchange(entry->returns_from, 0); from > 0)
    counters_.countUnpack(from, bytes);
  else
    counters_.countLoad(bytes, was_here_before);
  changed.notifyAll();
  return was_here_before;
}

template <class Key, class T, class Hash, class Note>
void SingleFlightCache<Key, T, Hash, Note>::fail(const EntryPtr& entry,
                                                 const std::exception_ptr& why,
                                                 Value value) noexcept {
  hide(entry);
  loading_bytes_ -= entry->bytes;
  loading_.erase(entry->place);
  entry->failure = why;
  entry->value = std::move(value);
  entry->state = Entry::State::kGone;
  if (entry->returns_from > 0)
    counters_.countEviction(entry->returns_from);
  else
    counters_.countFailure();
  changed.notifyAll();
}

template <class Key, class T, class Hash, class Note>
void SingleFlightCache<Key, T, Hash, Note>::hide(const EntryPtr& entry) noexcept {
  const auto found = entries_.find(entry->key);
  if (found != entries_.end() && found->second == entry) entries_.erase(found);
}

template <class Key, class T, class Hash, class Note>
auto SingleFlightCache<Key, T, Hash, Note>::take(MutexLock& lock, const EntryPtr& entry) -> Value {
  while (entry->state == Entry::State::kLoading) changed.wait(lock);
  --entry->wanted_by;
  if (entry->failure) std::rethrow_exception(entry->failure);
  return entry->value;
}

template <class Key, class T, class Hash, class Note>
template <class Suits>
auto SingleFlightCache<Key, T, Hash, Note>::coldest(Suits suits) const -> EntryPtr {
  for (auto at = recent_.rbegin(); at != recent_.rend(); ++at)
    if (suits((*at)->key) && mayGo(**at)) return *at;
  return nullptr;
}

template <class Key, class T, class Hash, class Note>
void SingleFlightCache<Key, T, Hash, Note>::evict(EntryPtr entry) {
  counters_.countEviction(entry->bytes);
  entries_.erase(entry->key);
  entry->state = Entry::State::kGone;
  recent_.erase(entry->place);
}

template <class Key, class T, class Hash, class Note>
bool SingleFlightCache<Key, T, Hash, Note>::makeRoom(uint64_t bytes) {
  while (takenBytes() + bytes > counters_.budget_bytes) {
    const EntryPtr entry = coldest();
    if (entry == nullptr) return false;
    evict(entry);
  }
  return true;
}

template <class Key, class T, class Hash, class Note>
void SingleFlightCache<Key, T, Hash, Note>::pack(EntryPtr entry, uint64_t bytes) {
  counters_.countPack(entry->bytes, bytes);
  entries_.erase(entry->key);
  entry->state = Entry::State::kGone;
  recent_.erase(entry->place);
}

}  // namespace sluice
