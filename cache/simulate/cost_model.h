// CostModel: the cost of moving and drawing on a machine, for modelled seconds.
//
//   seconds = bytes moved / bytes a second + pages moved * seconds a page + binds * seconds a bind
//
// Nothing is overlapped and drawing itself is left out: this compares orders, policies and merges
// on one machine, it predicts no frame time.
#pragma once

#include <cstdint>

namespace sluice {

struct CostModel {
  double bytes_per_second = 1e9;   // speed of the upload path; assumed: a round number
  double seconds_per_page = 1e-6;  // a page's share of overhead; assumed
  double seconds_per_bind = 5e-6;  // making a chunk the current texture; assumed

  double seconds(uint64_t bytes_moved, uint64_t pages_moved, uint64_t binds) const {
    return static_cast<double>(bytes_moved) / bytes_per_second +
           static_cast<double>(pages_moved) * seconds_per_page +
           static_cast<double>(binds) * seconds_per_bind;
  }
};

// Tong's Octane. Known: algorithm I moves the 64 MiB of Head III in 3.575 s, drawing included, so
// uploads go at no less than 19 MB/s. Assumed: 30 MB/s (half of the time is drawing) and the two
// overheads.
constexpr CostModel octaneCosts() {
  return {30e6, 10e-6, 100e-6};
}

}  // namespace sluice
