#include "src/classify/transfer/hounsfield.h"

#include <algorithm>

namespace sluice {
namespace {

// Below this there is nothing.
constexpr double kLeastHounsfield = -1100;
// The values of air, and those of fat, water and soft tissue.
constexpr ValueRange kAir{-1050, -900}, kTissue{-200, 200};

// Shares of all voxels but padding.
struct Shares {
  double air = 0, between = 0, tissue = 0, bone = 0;
};

Shares sharesOf(const ValueCounts& counts) {
  const uint64_t all = std::max<uint64_t>(1, total(counts));
  const auto share = [&](double lo, double hi) {
    return static_cast<double>(total(inside(counts, {lo, hi}))) / static_cast<double>(all);
  };
  return {share(kAir.lo, kAir.hi), share(kAir.hi, kTissue.lo), share(kTissue.lo, kTissue.hi),
          share(kBone, 1e9)};
}

// Whether values from air to tissue form two peaks: their densities are above twice that between
// them, and few values lie elsewhere.
bool areAirAndTissue(const Shares& shares) {
  constexpr double kLeast = 0.6, kLeastTimes = 2;
  const auto width = [](double lo, double hi) { return hi - lo; };
  const double between = shares.between / width(kAir.hi, kTissue.lo);
  return shares.air + shares.tissue > kLeast &&
         shares.air / width(kAir.lo, kAir.hi) > kLeastTimes * between &&
         shares.tissue / width(kTissue.lo, kTissue.hi) > kLeastTimes * between;
}

}  // namespace

ValueCounts withoutPadding(ValueCounts counts) {
  constexpr size_t kMostPaddings = 2;
  std::vector<ValueCount>& entries = counts.entries;
  size_t below = 0;
  while (below < entries.size() && entries[below].hi < kLeastHounsfield) ++below;
  if (below <= kMostPaddings)
    entries.erase(entries.begin(), entries.begin() + static_cast<ptrdiff_t>(below));
  return counts;
}

bool looksLikeHounsfield(const ValueCounts& values) {
  constexpr double kLeastShare = 0.02, kMost = 70000;
  if (values.entries.empty()) return false;
  const ValueRange range = rangeOf(values);
  if (range.lo < kLeastHounsfield || range.lo > -900 || range.hi > kMost) return false;
  const Shares shares = sharesOf(values);
  return shares.air > kLeastShare && shares.tissue > kLeastShare &&
         (range.hi >= kBone || areAirAndTissue(shares));
}

bool hasBone(const ValueCounts& values) {
  constexpr double kLeastBone = 0.002;
  return sharesOf(values).bone > kLeastBone;
}

}  // namespace sluice
