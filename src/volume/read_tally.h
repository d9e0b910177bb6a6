// What voxels are read for: ReadTally adds up what one purpose took, a frame say, over the threads
// that read for it; ReadPurpose goes with the reading from level to level.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "src/base/stop_token.h"

namespace sluice {

struct ReadTally {
  std::atomic<uint64_t> decoded_bytes{0};  // voxels that level 2 read
  std::atomic<uint64_t> copied_bytes{0};   // voxels into the texture buffer
  // Of all threads together.
  std::atomic<int64_t> read_ns{0}, decode_ns{0}, copy_ns{0};
};

// What is read is added to the tally, where there is one, and nothing more is read once `stop` asks
// for it.
struct ReadPurpose {
  std::shared_ptr<ReadTally> tally = {};
  StopToken stop = {};
};

inline double secondsOf(const std::atomic<int64_t>& nanoseconds) {
  return static_cast<double>(nanoseconds.load()) * 1e-9;
}

}  // namespace sluice
