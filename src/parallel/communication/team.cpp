#include "src/parallel/communication/team.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "src/base/error.h"
#include "src/base/values/bytes.h"

namespace sluice {
namespace {

// The state that each rank sends before anything else.
constexpr uint64_t kGoesOn = 0, kFailed = 1;

std::string lineOf(const std::vector<std::string>& reasons) {
  const auto fails = [](const std::string& reason) { return !reason.empty(); };
  const auto first = std::find_if(reasons.begin(), reasons.end(), fails);
  SLUICE_CHECK(first != reasons.end());
  // All ranks often fail for one reason, such as a missing file. One rank's number would mislead
  // then.
  if (std::count(reasons.begin(), reasons.end(), *first) == static_cast<long>(reasons.size()))
    return *first;
  const auto failed = std::count_if(reasons.begin(), reasons.end(), fails);
  std::string line =
      fmt::format("rank {} of {}: {}", first - reasons.begin(), reasons.size(), *first);
  if (failed > 1) line += fmt::format(" (and {} more)", failed - 1);
  return line;
}

}  // namespace

RankFailed::RankFailed(const std::vector<std::string>& reasons)
    : std::runtime_error(lineOf(reasons)) {}

Message asMessage(std::string_view text) {
  const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
  return {bytes, bytes + text.size()};
}

std::string asText(const Message& message) {
  return {reinterpret_cast<const char*>(message.data()), message.size()};
}

Team::Team(std::unique_ptr<Communicator> communicator, StopToken stop)
    : communicator_(std::move(communicator)), stop_(std::move(stop)) {}

void Team::throwFailed(const std::vector<uint64_t>& states, const std::string& mine) {
  const auto count = static_cast<size_t>(ranks());
  const size_t each = states.size() / count;
  std::vector<Message> to(count, asMessage(mine));
  std::vector<uint64_t> from_bytes(count);
  for (size_t r = 0; r < count; ++r)
    // A rank that goes on gives an empty reason, whatever sizes it had announced for its messages.
    from_bytes[r] = states[r * each] == kGoesOn ? 0 : states[r * each + 1];
  std::vector<std::string> reasons;
  for (const Message& reason : communicator_->exchange(std::move(to), from_bytes, stop_))
    reasons.push_back(asText(reason));
  throw RankFailed(reasons);
}

std::vector<uint64_t> Team::agree(const std::vector<uint64_t>& sizes) {
  std::vector<uint64_t> mine{kGoesOn};
  mine.insert(mine.end(), sizes.begin(), sizes.end());
  std::vector<uint64_t> all = communicator_->gatherAll(mine, stop_);
  for (size_t r = 0; r < static_cast<size_t>(ranks()); ++r)
    if (all[r * mine.size()] != kGoesOn) throwFailed(all, "");
  return all;
}

RankFailed Team::fail(const std::string& reason) {
  std::vector<uint64_t> mine(static_cast<size_t>(ranks()) + 2);  // as in exchange()
  // An empty reason would stand for a rank that did not fail.
  const std::string said = reason.empty() ? "failed" : reason;
  mine[0] = kFailed;
  mine[1] = said.size();
  try {
    throwFailed(communicator_->gatherAll(mine, stop_), said);
  } catch (const RankFailed& all) {
    return all;
  }
}

std::vector<Message> Team::exchange(std::vector<Message> to, uint64_t most_bytes) {
  const auto count = static_cast<size_t>(ranks()), me = static_cast<size_t>(rank());
  SLUICE_CHECK_EQ(to.size(), count);
  std::vector<uint64_t> sizes{most_bytes};
  for (const Message& message : to) sizes.push_back(message.size());
  // Each rank gave its state, how much it accepts, and how much it sends to each.
  const std::vector<uint64_t> all = agree(sizes);
  const size_t each = count + 2;
  // Every rank checks the sums of all, so that all throw together and none waits for a message.
  for (size_t r = 0; r < count; ++r) {
    uint64_t sum = 0;
    for (size_t giver = 0; giver < count; ++giver)
      // The message to itself is there already and takes no further memory.
      if (giver != r) sum += all[giver * each + 2 + r];
    if (sum > all[r * each + 1])
      failMemory(
          "rank {} of {}: other ranks' parts of the picture take {}, its --memory leaves {}; give "
          "more --memory or a smaller --size",
          r, count, formatBytes(sum), formatBytes(all[r * each + 1]));
  }
  std::vector<uint64_t> from_bytes(count);
  for (size_t giver = 0; giver < count; ++giver) from_bytes[giver] = all[giver * each + 2 + me];
  return communicator_->exchange(std::move(to), from_bytes, stop_);
}

std::vector<Message> Team::gatherAll(const Message& mine) {
  return exchange(std::vector<Message>(static_cast<size_t>(ranks()), mine));
}

std::vector<Message> Team::gather(Message mine) {
  std::vector<Message> to(static_cast<size_t>(ranks()));
  to[0] = std::move(mine);
  std::vector<Message> from = exchange(std::move(to));
  return isFirst() ? std::move(from) : std::vector<Message>();
}

std::string Team::fromFirst(std::string_view mine) {
  std::vector<Message> to(static_cast<size_t>(ranks()));
  if (isFirst()) std::fill(to.begin(), to.end(), asMessage(mine));
  return asText(exchange(std::move(to))[0]);
}

void Team::wait() {
  exchange(std::vector<Message>(static_cast<size_t>(ranks())));
}

int Team::ranksBeside(std::string_view host_and_processors) {
  const std::vector<Message> all = gatherAll(asMessage(host_and_processors));
  return static_cast<int>(std::count(all.begin(), all.end(), asMessage(host_and_processors)));
}

}  // namespace sluice
