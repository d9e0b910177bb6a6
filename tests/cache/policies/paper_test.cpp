// Each policy, as the simulator replays it, against its paper on traces of a million requests.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "cache/policies/random.h"
#include "cache/simulate/simulator.h"
#include "tests/cache/policies/paper_policies.h"

namespace sluice {
namespace {

constexpr size_t kRequests = 1'000'000;
constexpr Key kKeys = 20'000;

// Key k with a chance as 1 / (k + 1)^0.9, keys in no order of their numbers.
std::vector<Key> zipf() {
  std::vector<double> upTo(kKeys);
  double sum = 0;
  for (Key k = 0; k < kKeys; ++k) upTo[k] = sum += std::pow(k + 1, -0.9);
  Random random(17);
  std::vector<Key> keys(kRequests);
  for (Key& key : keys) {
    const double drawn = static_cast<double>(random.next() >> 11) * 0x1p-53 * sum;
    const auto rank = std::lower_bound(upTo.begin(), upTo.end(), drawn) - upTo.begin();
    key = static_cast<Key>(static_cast<uint64_t>(rank) * 7919 % kKeys);
  }
  return keys;
}

// All keys in a row again and again.
std::vector<Key> loop() {
  std::vector<Key> keys(kRequests);
  for (size_t i = 0; i < kRequests; ++i) keys[i] = static_cast<Key>(i % 3000);
  return keys;
}

// Zipf, interrupted by scans of keys that come only once.
std::vector<Key> scans() {
  std::vector<Key> keys = zipf();
  Key fresh = kKeys;
  for (size_t i = 0; i < kRequests; ++i)
    if (i % 50'000 >= 35'000) keys[i] = fresh++;
  return keys;
}

class EveryPaper : public testing::TestWithParam<PolicyKind> {};

TEST_P(EveryPaper, missesAsOftenOnAMillionRequests) {
  const std::pair<std::string, std::vector<Key>> traces[] = {
      {"zipf", zipf()}, {"loop", loop()}, {"scans", scans()}};
  for (const auto& [what, keys] : traces) {
    const PreparedTrace trace = prepareUnit(keys);
    for (const uint64_t pages : {70, 2048}) {
      const uint64_t misses = test::paperMisses(GetParam(), pages, keys);
      EXPECT_EQ(simulate(trace, {GetParam(), pages}, 0).misses, misses) << what << ' ' << pages;
      EXPECT_GE(misses, std::min<uint64_t>(trace.distinct_pages, pages));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, EveryPaper,
                         testing::Values(PolicyKind::kLru, PolicyKind::kFifo, PolicyKind::kClock,
                                         PolicyKind::kSieve, PolicyKind::kS3Fifo, PolicyKind::kArc,
                                         PolicyKind::kTwoQ, PolicyKind::kBelady),
                         [](const auto& param_info) {
                           std::string text(name(param_info.param));
                           std::erase(text, '-');
                           return text;
                         });

}  // namespace
}  // namespace sluice
