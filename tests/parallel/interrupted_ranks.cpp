// Two ranks: rank 1 sends a message, and rank 0 stops waiting for it before it is there. Nothing
// may then be written into memory that was the message's, and the next message must arrive. Prints
// the failure; exit status 0: none.
//
//   mpirun -n 2 interrupted_ranks waiting   (rank 0 gives up before rank 1 sends)
//   mpirun -n 2 interrupted_ranks arriving  (rank 0 gives up while the message arrives)
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <thread>

#include "src/parallel/communication/mpi_ranks.h"

namespace sluice {
namespace {

constexpr size_t kBytes = 48 << 20;
constexpr std::byte kSent{0xaa}, kLast{0x77}, kOwn{0x55};

void sleepMs(int ms) {
  std::this_thread::sleep_for(std::chrono::milliseconds(ms));
}

bool areAll(const Message& message, std::byte expected) {
  for (const std::byte byte : message)
    if (byte != expected) return false;
  return true;
}

// Throws away the message from rank 1, after so long.
bool giveUp(Communicator& ranks, int after_ms) {
  StopSource stop;
  if (after_ms == 0) stop.requestStop();
  std::jthread later([&] {
    sleepMs(after_ms);
    stop.requestStop();
  });
  try {
    ranks.exchange(std::vector<Message>(2), std::vector<uint64_t>{0, kBytes}, stop.token());
  } catch (const Interrupted&) {
    return true;
  }
  return false;
}

// The next message of rank 1, at most kBytes long.
Message receive(Communicator& ranks) {
  return ranks.exchange(std::vector<Message>(2), std::vector<uint64_t>{0, kBytes}, {})[1];
}

void send(Communicator& ranks, Message message) {
  std::vector<Message> to(2);
  to[0] = std::move(message);
  ranks.exchange(std::move(to), std::vector<uint64_t>{0, 0}, {});
}

void meet(Communicator& ranks) {
  ranks.gatherAll(std::vector<uint64_t>{1}, {});
}

// The failure; null: none. A message that arrives while it is given up may be lost, but no other.
const char* runFirst(Communicator& ranks, bool is_arriving) {
  if (is_arriving) sleepMs(300);
  if (!giveUp(ranks, is_arriving ? 0 : 100)) return "was not interrupted";
  if (!is_arriving) meet(ranks);
  // In the place of the message that was given up, if that is free.
  std::vector<Message> own(4, Message(kBytes, kOwn));
  bool has_come = false;
  for (Message next = receive(ranks); next[0] != kLast; next = receive(ranks)) {
    if (has_come || !areAll(next, kSent)) return "another message than was sent";
    has_come = true;
  }
  meet(ranks);
  for (const Message& mine : own)
    if (!areAll(mine, kOwn)) return "a message was written into memory of others";
  return has_come || is_arriving ? nullptr : "a message was lost";
}

int runRanks(bool is_arriving) {
  const auto ranks = joinRanks(launchOf([](const char* name) { return std::getenv(name); }));
  const char* wrong = nullptr;
  if (ranks->rank() == 0) {
    wrong = runFirst(*ranks, is_arriving);
  } else {
    if (!is_arriving) meet(*ranks);
    send(*ranks, Message(kBytes, kSent));
    send(*ranks, Message(8, kLast));
    meet(*ranks);
  }
  if (wrong != nullptr) std::printf("%s\n", wrong);
  ranks->finish();
  return wrong == nullptr ? 0 : 1;
}

}  // namespace
}  // namespace sluice

int main(int argc, char** argv) {
  return sluice::runRanks(argc > 1 && std::string_view(argv[1]) == "arriving");
}
