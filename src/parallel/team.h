// Team: this rank and the others of a run, and what becomes of all when one of them fails.
//
// A rank that fails says so where the others next hear from it, so that none waits for what does
// not come: its own call of fail() gives everyone's failures, and the others' next call throws
// RankFailed with the same. All ranks make the same calls in the same order. One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "src/parallel/communicator.h"

namespace sluice {

// Why ranks failed, by rank; empty for those that did not.
class RankFailed : public std::runtime_error {
 public:
  explicit RankFailed(const std::vector<std::string>& reasons);
  // what(): one line. "rank 2 of 4: disk full"; a failure of all for one reason is that alone.
};

class Team {
 public:
  explicit Team(std::unique_ptr<Communicator> communicator, StopToken stop = {});

  int rank() const { return communicator_->rank(); }
  int ranks() const { return communicator_->ranks(); }
  bool isFirst() const { return rank() == 0; }

  // to[r] goes to rank r; gives what came from each. Where a rank would get more than `most_bytes`
  // all throw Error, which names it. These throw RankFailed and Interrupted.
  std::vector<Message> exchange(std::vector<Message> to, uint64_t most_bytes = UINT64_MAX);
  // Everyone's, by rank.
  std::vector<Message> gatherAll(const Message& mine);
  // At rank 0 everyone's; elsewhere nothing.
  std::vector<Message> gather(Message mine);
  // Rank 0's.
  std::string fromFirst(std::string_view mine);
  void wait();

  // This rank has failed: tells all, and gives what all then know. Once; nothing may follow.
  RankFailed fail(const std::string& reason);
  // All is done. Nothing may follow.
  void finish() { communicator_->finish(); }

  // Ranks that share processors with this one, itself included: those of the same host that may run
  // on the same ones.
  int ranksBeside(std::string_view host_and_processors);

 private:
  // Everyone's state and sizes; throws RankFailed.
  std::vector<uint64_t> agree(const std::vector<uint64_t>& sizes);
  [[noreturn]] void throwFailed(const std::vector<uint64_t>& states, const std::string& mine);

  const std::unique_ptr<Communicator> communicator_;
  const StopToken stop_;
};

Message asMessage(std::string_view text);
std::string asText(const Message& message);

}  // namespace sluice
