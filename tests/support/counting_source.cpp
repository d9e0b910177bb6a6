#include "tests/support/counting_source.h"

#include <algorithm>

namespace sluice {

void CountingSource::readRegion(int64_t time, const Box3& box, std::span<std::byte> out) {
  const RegionRead region{box, out};
  readRegions(time, std::span(&region, 1));
}

void CountingSource::readRegions(int64_t time, std::span<const RegionRead> regions) {
  {
    const std::lock_guard lock(mutex_);
    counts_.max_at_once = std::max(counts_.max_at_once, ++under_way_);
  }
  try {
    source_.readRegions(time, regions);
  } catch (...) {
    const std::lock_guard lock(mutex_);
    --under_way_;
    ++counts_.failures;
    throw;
  }
  const std::lock_guard lock(mutex_);
  --under_way_;
  ++counts_.calls;
  for (const auto& [box, out] : regions) {
    counts_.voxels += box.count();
    counts_.bytes += static_cast<int64_t>(out.size());
    reads_.push_back({time, box});
  }
}

CountingSource::Counts CountingSource::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::vector<CountingSource::Read> CountingSource::reads() const {
  const std::lock_guard lock(mutex_);
  return reads_;
}

int64_t CountingSource::timesRead(int64_t time, const Box3& box) const {
  const std::lock_guard lock(mutex_);
  return std::count(reads_.begin(), reads_.end(), Read{time, box});
}

void CountingSource::reset() {
  const std::lock_guard lock(mutex_);
  counts_ = {};
  reads_.clear();
}

}  // namespace sluice
