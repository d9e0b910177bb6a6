// PageExtents: the free pages of a cache in which a chunk takes the lowest ones, as in
// TextureCache. They are kept as runs of pages, so that a chunk of many pages costs no more than a
// chunk of few. One thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "src/base/error.h"

namespace sluice {

class PageExtents {
 public:
  struct Extent {
    uint64_t begin, end;  // pages [begin, end)
    friend bool operator==(const Extent&, const Extent&) = default;
  };

  explicit PageExtents(uint64_t pages) {
    if (pages > 0) free_[0] = pages;
  }

  // The lowest free pages. Requires: so many are free.
  std::vector<Extent> take(uint64_t pages) {
    std::vector<Extent> taken;
    while (pages > 0) {
      SLUICE_CHECK(!free_.empty());
      const auto [begin, end] = *free_.begin();
      free_.erase(free_.begin());
      const uint64_t cut = std::min(end, begin + pages);
      if (cut < end) free_[cut] = end;
      taken.push_back({begin, cut});
      pages -= cut - begin;
    }
    return taken;
  }

  // Requires: taken before and not given back since.
  void giveBack(const std::vector<Extent>& extents) {
    for (Extent e : extents) {
      const auto after = free_.lower_bound(e.begin);
      if (after != free_.end() && after->first == e.end) e.end = after->second;
      if (after != free_.begin() && std::prev(after)->second == e.begin)
        e.begin = std::prev(after)->first;
      if (after != free_.end() && after->second == e.end) free_.erase(after);
      free_[e.begin] = e.end;
    }
  }

 private:
  std::map<uint64_t, uint64_t> free_;  // begin -> end of runs that do not touch
};

}  // namespace sluice
