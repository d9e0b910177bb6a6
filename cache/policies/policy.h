// Policy: which entries of a cache go when another needs their room.
//
// A single interface for all online policies and for Belady's optimum by request. An entry is a key
// with a weight in pages. The answer to a request is a hit, a load (with the keys that were evicted
// for it), or that the entry does not fit. Entries of several pages go and come as a whole: on a
// miss, victims are chosen one after the other until the new entry fits, so a miss may evict none,
// one or many. Pinned entries are never chosen: the chunks of the cluster being drawn stay. A
// request that could not be met even by evicting everything unpinned changes nothing and answers
// kDoesNotFit.
//
// Keys are small numbers (KeyTable makes them): the state is one flat array indexed by key, lists
// are linked by index, and no request allocates once reserve() has been called. An entry keeps the
// weight that it was loaded with; a hit that names another weight does not change it.
//
// Deterministic: the same requests give the same answers on every machine. One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace sluice {

using Key = uint32_t;

enum class Outcome {
  kHit,
  kLoaded,     // was not resident, is now
  kDoesNotFit  // heavier than the capacity less the pinned entries; nothing changed
};

class Policy {
 public:
  // Requires: capacity > 0 (pages).
  explicit Policy(uint64_t capacity);
  virtual ~Policy() = default;
  Policy(const Policy&) = delete;
  Policy& operator=(const Policy&) = delete;

  // Appends the keys evicted, in the order in which they went, to `evicted`.
  // Requires: weight > 0; key < 2^32 - 16.
  Outcome request(Key key, uint32_t weight, std::vector<Key>& evicted) {
    const uint32_t index = key + kHeads;
    if (index >= nodes_.size()) reserve(key + 1);
    ++clock_;
    if (nodes_[index].resident) {
      onHit(index);
      return Outcome::kHit;
    }
    if (weight > capacity_ - pinned_weight_) return Outcome::kDoesNotFit;
    evicted_ = &evicted;
    onMiss(index, weight);
    return Outcome::kLoaded;
  }

  // Keeps a resident entry from being evicted until unpinAll(). False when it is not resident.
  bool pin(Key key);
  void unpinAll();
  // Takes a resident entry out (it became invalid), pinned or not, and removes it from ghost lists.
  // False when it was not resident.
  bool erase(Key key);

  // True if the key is resident. Ghosts that a policy remembers are not.
  bool contains(Key key) const {
    return key + kHeads < nodes_.size() && nodes_[key + kHeads].resident;
  }
  // Weight a resident entry was loaded with. Requires: contains(key).
  uint32_t weightOf(Key key) const { return nodes_[key + kHeads].weight; }
  uint64_t capacity() const { return capacity_; }
  uint64_t used() const { return used_; }            // pages of the resident entries
  uint64_t residents() const { return residents_; }  // their number

  // Room for keys below `keys`.
  void reserve(Key keys);
  // Hints for callers that know the next requests: prefetchEntry well ahead, then prefetchNeighbors
  // (which reads the entry). They change nothing but the processor's cache.
  void prefetchEntry(Key key) const {
    if (key + kHeads < nodes_.size()) __builtin_prefetch(&nodes_[key + kHeads]);
  }
  void prefetchNeighbors(Key key) const {
    if (key + kHeads >= nodes_.size()) return;
    __builtin_prefetch(&nodes_[nodes_[key + kHeads].prev]);
    __builtin_prefetch(&nodes_[nodes_[key + kHeads].next]);
  }

 protected:
  // The lists' heads come first in the node array, so that linking needs no special case.
  static constexpr uint32_t kHeads = 8;
  struct Node {
    uint32_t prev, next;  // towards the head (newest), towards the tail (oldest); self when alone
    uint32_t weight = 0;
    uint8_t list = 0;  // which list it is in; resident entries and ghosts alike
    uint8_t mark = 0;  // the policy's own: reference bit, prediction, frequency
    bool resident = false;
    bool pinned = false;
  };

  virtual void onHit(uint32_t index) = 0;
  // Makes room and puts the entry in with admit(). `nodes_[index]` may be a ghost.
  virtual void onMiss(uint32_t index, uint32_t weight) = 0;
  // Called before a resident entry leaves its list for good.
  virtual void onRemoval(uint32_t /*index*/) {}

  bool isFull(uint32_t weight) const { return used_ + weight > capacity_; }
  uint32_t tail(uint32_t list) const { return nodes_[list].prev; }
  bool isEmpty(uint32_t list) const { return nodes_[list].prev == list; }
  uint64_t listWeight(uint32_t list) const { return list_weight_[list]; }
  // The oldest entry of a list that is not pinned; the list's own number when there is none.
  uint32_t oldestUnpinned(uint32_t list) const {
    uint32_t i = nodes_[list].prev;
    while (i != list && nodes_[i].pinned) i = nodes_[i].prev;
    return i;
  }
  // Whether it is in a list: resident, or remembered by a ghost list.
  bool isLinked(uint32_t index) const { return nodes_[index].next != index; }
  void pushHead(uint32_t list, uint32_t index);
  void unlink(uint32_t index);
  // Moves it to the head of its list.
  void touch(uint32_t index);
  // All of `from`, order kept, to the head of `to`, whose entries all count as older.
  void spliceToHead(uint32_t from, uint32_t to);
  // Makes the entry resident, at the head of `list`. Requires: in no list; room is there.
  void admit(uint32_t index, uint32_t weight, uint32_t list);
  // Takes it out of its list and the cache; reported to the caller of request().
  void evict(uint32_t index);

  std::vector<Node> nodes_;
  uint64_t clock_ = 0;  // requests so far, this one included

 private:
  void removeResident(uint32_t index);

  const uint64_t capacity_;
  uint64_t used_ = 0;
  uint64_t residents_ = 0;
  uint64_t pinned_weight_ = 0;
  uint64_t list_weight_[kHeads] = {};
  std::vector<uint32_t> pinned_;
  std::vector<Key>* evicted_ = nullptr;  // for the request under way
};

enum class PolicyKind {
  kLru,
  kFifo,
  kClock,
  kRandom,
  kSrrip,
  kTwoQ,
  kArc,
  kS3Fifo,
  kSieve,
  kLfu,
  kSlru,
  kWTinyLfu,
  kLirs,
  kGdsf,
  kBelady,      // the optimum by request: needs the whole trace
  kBeladyPages  // the optimum by byte: see belady.h
};

// The policies that need no knowledge of the future, in the order above.
std::span<const PolicyKind> onlinePolicies();
// All policies, in the order above.
std::span<const PolicyKind> allPolicies();
// The names that --policy takes, as "lru" and "w-tinylfu".
std::string_view name(PolicyKind kind);
std::optional<PolicyKind> parsePolicy(std::string_view text);

// Requires: an online kind; capacity > 0. `seed` is for kRandom.
std::unique_ptr<Policy> makePolicy(PolicyKind kind, uint64_t capacity, uint64_t seed = 1);

}  // namespace sluice
