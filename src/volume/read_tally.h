// ReadTally adds up what reading for one purpose, such as a frame, took over all threads.
// ReadPurpose carries the purpose from level to level.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "src/base/threads/stop_token.h"

namespace sluice {

struct ReadTally {
  std::atomic<uint64_t> decoded_bytes{0};  // voxels that level 2 read
  std::atomic<uint64_t> copied_bytes{0};   // voxels into the texture buffer
  // Time of all threads together.
  std::atomic<int64_t> read_ns{0}, decode_ns{0}, copy_ns{0};
};

// Reads are added to the tally, if there is one, and end as soon as `stop` asks for it.
struct ReadPurpose {
  std::shared_ptr<ReadTally> tally = {};
  StopToken stop = {};
};

inline double secondsOf(const std::atomic<int64_t>& nanoseconds) {
  return static_cast<double>(nanoseconds.load()) * 1e-9;
}

}  // namespace sluice
