// Progress: how far work that takes a while is.
#pragma once

#include <cstdint>
#include <functional>

namespace sluice {

// Work that takes a while, and how much of it is done.
struct Progress {
  enum class Stage {
    kIndexing,  // the first opening of a volume passes over its voxels: bytes
    kDecoding,  // a compressed volume of one stream is unpacked once: bytes
    kDrawing,   // a picture: groups of blocks drawn, from 0 on
  };
  Stage stage = Stage::kDrawing;
  uint64_t done = 0;
  uint64_t total = 0;  // known so far; 0 if there is nothing to do

  // 0 to 1.
  double share() const {
    return done >= total ? 1 : static_cast<double>(done) / static_cast<double>(total);
  }
};

// Called by threads of the library, one call at a time for each Volume and Renderer. It should
// return soon, and must not call the object whose progress it reports. An exception from it ends
// the work and leaves the call that the function was passed to.
using ProgressFunction = std::function<void(const Progress&)>;

}  // namespace sluice
