// Team: this rank and the others of a run, and how all end when one of them fails.
//
// A rank that fails reports it in the next collective call, so that no rank waits in vain: its own
// call of fail() returns all ranks' failures, and the others' next call throws RankFailed with the
// same text. All ranks make the same calls in the same order. One thread.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "src/parallel/communication/communicator.h"

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

  // Sends to[r] to rank r and returns what came from each rank. If a rank would receive more than
  // `most_bytes`, all throw Error, which names it. These throw RankFailed and Interrupted.
  std::vector<Message> exchange(std::vector<Message> to, uint64_t most_bytes = UINT64_MAX);
  // Everyone's, by rank.
  std::vector<Message> gatherAll(const Message& mine);
  // Everyone's messages at rank 0; elsewhere nothing.
  std::vector<Message> gather(Message mine);
  // Rank 0's.
  std::string fromFirst(std::string_view mine);
  void wait();

  // This rank has failed: tells all ranks, and returns what all then know. To be called once; no
  // call may follow.
  RankFailed fail(const std::string& reason);
  // All is done. Nothing may follow.
  void finish() { communicator_->finish(); }

  // Ranks that share processors with this one, itself included: ranks of the same host that may run
  // on the same processors.
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
