#include "cache/policies/policy.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "cache/policies/counting_policies.h"
#include "cache/policies/ghost_policies.h"
#include "cache/policies/lirs_policy.h"
#include "cache/policies/segmented_policies.h"
#include "cache/policies/simple_policies.h"
#include "src/base/error.h"

namespace sluice {
namespace {

template <class OnePolicy>
std::unique_ptr<Policy> make(uint64_t capacity, uint64_t seed) {
  if constexpr (std::is_constructible_v<OnePolicy, uint64_t, uint64_t>)
    return std::make_unique<OnePolicy>(capacity, seed);
  else
    return std::make_unique<OnePolicy>(capacity);
}

struct PolicyRow {
  PolicyKind kind;
  std::string_view name;
  std::unique_ptr<Policy> (*make)(uint64_t capacity, uint64_t seed);
};
// The rows have the order of PolicyKind. Policies that know the future come last: belady.h makes
// them.
constexpr std::array kPolicies{
    PolicyRow{PolicyKind::kLru, "lru", make<LruPolicy>},
    PolicyRow{PolicyKind::kFifo, "fifo", make<FifoPolicy>},
    PolicyRow{PolicyKind::kClock, "clock", make<ClockPolicy>},
    PolicyRow{PolicyKind::kRandom, "random", make<RandomPolicy>},
    PolicyRow{PolicyKind::kSrrip, "srrip", make<SrripPolicy>},
    PolicyRow{PolicyKind::kTwoQ, "2q", make<TwoQPolicy>},
    PolicyRow{PolicyKind::kArc, "arc", make<ArcPolicy>},
    PolicyRow{PolicyKind::kS3Fifo, "s3-fifo", make<S3FifoPolicy>},
    PolicyRow{PolicyKind::kSieve, "sieve", make<SievePolicy>},
    PolicyRow{PolicyKind::kLfu, "lfu", make<LfuPolicy>},
    PolicyRow{PolicyKind::kSlru, "slru", make<SlruPolicy>},
    PolicyRow{PolicyKind::kWTinyLfu, "w-tinylfu", make<WTinyLfuPolicy>},
    PolicyRow{PolicyKind::kLirs, "lirs", make<LirsPolicy>},
    PolicyRow{PolicyKind::kGdsf, "gdsf", make<GdsfPolicy>},
    PolicyRow{PolicyKind::kBelady, "belady", nullptr},
    PolicyRow{PolicyKind::kBeladyPages, "belady-pages", nullptr},
};
constexpr size_t kOnline =
    std::ranges::count_if(kPolicies, [](const PolicyRow& row) { return row.make != nullptr; });

constexpr auto kKinds = [] {
  std::array<PolicyKind, kPolicies.size()> kinds{};
  std::ranges::transform(kPolicies, kinds.begin(), &PolicyRow::kind);
  return kinds;
}();

constexpr const PolicyRow& rowOf(PolicyKind kind) {
  return kPolicies[static_cast<size_t>(kind)];
}
static_assert(std::ranges::all_of(kKinds,
                                  [](PolicyKind kind) { return rowOf(kind).kind == kind; }));

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
  return std::span(kKinds).first<kOnline>();
}

std::span<const PolicyKind> allPolicies() {
  return kKinds;
}

std::string_view name(PolicyKind kind) {
  return rowOf(kind).name;
}

std::optional<PolicyKind> parsePolicy(std::string_view text) {
  const auto found = std::ranges::find(kPolicies, text, &PolicyRow::name);
  return found == kPolicies.end() ? std::nullopt : std::optional(found->kind);
}

std::unique_ptr<Policy> makePolicy(PolicyKind kind, uint64_t capacity, uint64_t seed) {
  SLUICE_CHECK(rowOf(kind).make != nullptr);  // Belady's optimum needs the whole trace: belady.h
  return rowOf(kind).make(capacity, seed);
}

}  // namespace sluice
