#include "cache/policies/policy.h"

#include <algorithm>
#include <array>
#include <utility>

#include "cache/policies/counting_policies.h"
#include "cache/policies/ghost_policies.h"
#include "cache/policies/lirs_policy.h"
#include "cache/policies/segmented_policies.h"
#include "cache/policies/simple_policies.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr std::array kNames{
    std::pair{PolicyKind::kLru, "lru"},       std::pair{PolicyKind::kFifo, "fifo"},
    std::pair{PolicyKind::kClock, "clock"},   std::pair{PolicyKind::kRandom, "random"},
    std::pair{PolicyKind::kSrrip, "srrip"},   std::pair{PolicyKind::kTwoQ, "2q"},
    std::pair{PolicyKind::kArc, "arc"},       std::pair{PolicyKind::kS3Fifo, "s3-fifo"},
    std::pair{PolicyKind::kSieve, "sieve"},   std::pair{PolicyKind::kLfu, "lfu"},
    std::pair{PolicyKind::kSlru, "slru"},     std::pair{PolicyKind::kWTinyLfu, "w-tinylfu"},
    std::pair{PolicyKind::kLirs, "lirs"},     std::pair{PolicyKind::kGdsf, "gdsf"},
    std::pair{PolicyKind::kBelady, "belady"}, std::pair{PolicyKind::kBeladyPages, "belady-pages"},
};

constexpr std::array kOnline{PolicyKind::kLru,    PolicyKind::kFifo,   PolicyKind::kClock,
                             PolicyKind::kRandom, PolicyKind::kSrrip,  PolicyKind::kTwoQ,
                             PolicyKind::kArc,    PolicyKind::kS3Fifo, PolicyKind::kSieve,
                             PolicyKind::kLfu,    PolicyKind::kSlru,   PolicyKind::kWTinyLfu,
                             PolicyKind::kLirs,   PolicyKind::kGdsf};

}  // namespace

Policy::Policy(uint64_t capacity) : capacity_(capacity) {
  SLUICE_CHECK_LT(uint64_t{0}, capacity);
  reserve(0);
}

void Policy::reserve(Key keys) {
  const size_t wanted = size_t{keys} + kHeads;
  if (wanted <= nodes_.size()) return;
  SLUICE_CHECK_LE(wanted, size_t{UINT32_MAX});
  // Doubled, since keys come one by one.
  if (wanted > nodes_.capacity()) nodes_.reserve(std::max(wanted, nodes_.size() * 2));
  for (auto i = static_cast<uint32_t>(nodes_.size()); i < wanted; ++i)
    // Each node is a list of its own until it is put into one.
    nodes_.push_back({.prev = i, .next = i});
}

bool Policy::pin(Key key) {
  if (!contains(key)) return false;
  Node& node = nodes_[key + kHeads];
  if (!node.pinned) {
    node.pinned = true;
    pinned_weight_ += node.weight;
    pinned_.push_back(key + kHeads);
  }
  return true;
}

void Policy::unpinAll() {
  for (const uint32_t index : pinned_) nodes_[index].pinned = false;
  pinned_.clear();
  pinned_weight_ = 0;
}

bool Policy::erase(Key key) {
  const uint32_t index = key + kHeads;
  if (index >= nodes_.size()) return false;
  if (nodes_[index].resident) {
    removeResident(index);
    return true;
  }
  // A ghost is forgotten, too.
  if (isLinked(index)) unlink(index);
  return false;
}

void Policy::pushHead(uint32_t list, uint32_t index) {
  Node& head = nodes_[list];
  Node& node = nodes_[index];
  node.prev = list;
  node.next = head.next;
  nodes_[head.next].prev = index;
  head.next = index;
  node.list = static_cast<uint8_t>(list);
  list_weight_[list] += node.weight;
}

void Policy::unlink(uint32_t index) {
  Node& node = nodes_[index];
  nodes_[node.prev].next = node.next;
  nodes_[node.next].prev = node.prev;
  node.prev = node.next = index;
  list_weight_[node.list] -= node.weight;
}

void Policy::touch(uint32_t index) {
  // The list's weight stays, since the node stays in it.
  Node& node = nodes_[index];
  const uint32_t list = node.list;
  nodes_[node.prev].next = node.next;
  nodes_[node.next].prev = node.prev;
  Node& head = nodes_[list];
  node.prev = list;
  node.next = head.next;
  nodes_[head.next].prev = index;
  head.next = index;
}

void Policy::spliceToHead(uint32_t from, uint32_t to) {
  if (isEmpty(from)) return;
  // Each node knows its list, so that unlink() takes its weight off the right one.
  for (uint32_t i = nodes_[from].next; i != from; i = nodes_[i].next)
    nodes_[i].list = static_cast<uint8_t>(to);
  const uint32_t newest = nodes_[from].next;
  const uint32_t oldest = nodes_[from].prev;
  const uint32_t second = nodes_[to].next;
  nodes_[to].next = newest;
  nodes_[newest].prev = to;
  nodes_[oldest].next = second;
  nodes_[second].prev = oldest;
  nodes_[from].prev = nodes_[from].next = from;
  list_weight_[to] += list_weight_[from];
  list_weight_[from] = 0;
}

void Policy::admit(uint32_t index, uint32_t weight, uint32_t list) {
  Node& node = nodes_[index];
  node.weight = weight;
  node.mark = 0;
  node.resident = true;
  pushHead(list, index);
  used_ += weight;
  ++residents_;
  SLUICE_CHECK_LE(used_, capacity_);
}

void Policy::evict(uint32_t index) {
  SLUICE_CHECK(nodes_[index].resident && !nodes_[index].pinned);
  removeResident(index);
  evicted_->push_back(index - kHeads);
}

void Policy::removeResident(uint32_t index) {
  onRemoval(index);
  unlink(index);
  Node& node = nodes_[index];
  node.resident = false;
  used_ -= node.weight;
  --residents_;
  if (node.pinned) {
    node.pinned = false;
    pinned_weight_ -= node.weight;
    std::erase(pinned_, index);
  }
}

std::span<const PolicyKind> onlinePolicies() {
  return kOnline;
}

std::vector<PolicyKind> allPolicies() {
  std::vector<PolicyKind> kinds(kOnline.begin(), kOnline.end());
  kinds.insert(kinds.end(), {PolicyKind::kBelady, PolicyKind::kBeladyPages});
  return kinds;
}

std::string_view name(PolicyKind kind) {
  for (const auto& [k, text] : kNames) {
    if (k == kind) return text;
  }
  return "?";
}

std::optional<PolicyKind> parsePolicy(std::string_view text) {
  for (const auto& [k, known] : kNames) {
    if (known == text) return k;
  }
  return std::nullopt;
}

std::unique_ptr<Policy> makePolicy(PolicyKind kind, uint64_t capacity, uint64_t seed) {
  switch (kind) {
    case PolicyKind::kLru:
      return std::make_unique<LruPolicy>(capacity);
    case PolicyKind::kFifo:
      return std::make_unique<FifoPolicy>(capacity);
    case PolicyKind::kClock:
      return std::make_unique<ClockPolicy>(capacity);
    case PolicyKind::kRandom:
      return std::make_unique<RandomPolicy>(capacity, seed);
    case PolicyKind::kSrrip:
      return std::make_unique<SrripPolicy>(capacity);
    case PolicyKind::kTwoQ:
      return std::make_unique<TwoQPolicy>(capacity);
    case PolicyKind::kArc:
      return std::make_unique<ArcPolicy>(capacity);
    case PolicyKind::kS3Fifo:
      return std::make_unique<S3FifoPolicy>(capacity);
    case PolicyKind::kSieve:
      return std::make_unique<SievePolicy>(capacity);
    case PolicyKind::kLfu:
      return std::make_unique<LfuPolicy>(capacity);
    case PolicyKind::kSlru:
      return std::make_unique<SlruPolicy>(capacity);
    case PolicyKind::kWTinyLfu:
      return std::make_unique<WTinyLfuPolicy>(capacity);
    case PolicyKind::kLirs:
      return std::make_unique<LirsPolicy>(capacity);
    case PolicyKind::kGdsf:
      return std::make_unique<GdsfPolicy>(capacity);
    case PolicyKind::kBelady:
    case PolicyKind::kBeladyPages:
      break;
  }
  SLUICE_CHECK(!"Belady's optimum needs the whole trace: see belady.h");
  return nullptr;
}

}  // namespace sluice
