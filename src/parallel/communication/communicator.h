// Communicator: how the ranks of a run reach one another. Behind it is MPI or threads of one
// process. All ranks make the same calls in the same order. One thread a rank.
//
// The folder: communicators of MPI (mpi_ranks.h, mpi_module.h) and of threads (in_process.h), and
// how ranks end together when one fails (team.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/base/threads/stop_token.h"

namespace sluice {

using Message = std::vector<std::byte>;

class Communicator {
 public:
  virtual ~Communicator() = default;

  virtual int rank() const = 0;
  virtual int ranks() const = 0;
  // Each rank gives as many numbers and gets the numbers of all, rank after rank. Throws
  // Interrupted.
  virtual std::vector<uint64_t> gatherAll(std::span<const uint64_t> mine,
                                          const StopToken& stop) = 0;
  // to[r] goes to rank r. Returns the messages from each rank, from_bytes[r] long. The communicator
  // owns the messages on their way: if it throws Interrupted, others may still read and write them.
  virtual std::vector<Message> exchange(std::vector<Message> to,
                                        std::span<const uint64_t> from_bytes,
                                        const StopToken& stop) = 0;
  // To be called once, last, by all: until then a rank that goes counts as lost.
  virtual void finish() {}
};

}  // namespace sluice
