// OrderedParts: appends the parts that several threads make to the mesh's file in the order of the
// pieces, so that the file is the same for any number of threads. Any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "io/meshes/mesh_file.h"
#include "src/base/threads/mutex.h"

namespace sluice {

class OrderedParts {
 public:
  // Finished pieces may wait for others in at most so many bytes; `file` must outlive it.
  OrderedParts(MeshFile& file, uint64_t most_waiting_bytes)
      : file_(file), most_waiting_bytes_(most_waiting_bytes) {}

  // The next part of the piece at this position, and whether it is the piece's last one; leaves it
  // empty. Waits for earlier pieces if the part is not the last, or finds no room. False if the
  // work was given up. Throws Error from the file.
  bool put(size_t at, MeshPart& part, bool is_last);
  // Ends all waiting.
  void giveUp();

 private:
  MeshFile& file_;  // used by the thread whose turn it is
  const uint64_t most_waiting_bytes_;
  Mutex mutex_;
  Condition changed_;
  size_t turn_ SLUICE_GUARDED_BY(mutex_) = 0;
  bool is_given_up_ SLUICE_GUARDED_BY(mutex_) = false;
  uint64_t waiting_bytes_ SLUICE_GUARDED_BY(mutex_) = 0;
  std::map<size_t, MeshPart> waiting_ SLUICE_GUARDED_BY(mutex_);  // whole pieces
};

}  // namespace sluice
