#include "src/base/files/temporary_name.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>

namespace sluice {
namespace {

enum class State { kFree, kWritten, kSet };  // kWritten: its name is being written

struct Slot {
  std::atomic<State> state{State::kFree};
  std::array<char, 4096> path{};
};

// A process writes a few files at once. The memory is touched slot by slot.
std::array<Slot, 256> slots;
static_assert(std::atomic<State>::is_always_lock_free);  // a signal handler may read it

}  // namespace

TemporaryName::TemporaryName(const std::filesystem::path& path) {
  const std::string& name = path.native();
  // Such a name is not removed after a signal; nothing else is lost.
  if (name.size() >= slots.front().path.size()) return;
  for (size_t i = 0; i < slots.size() && slot_ < 0; ++i) {
    State free = State::kFree;
    if (!slots[i].state.compare_exchange_strong(free, State::kWritten)) continue;
    std::memcpy(slots[i].path.data(), name.c_str(), name.size() + 1);
    slots[i].state = State::kSet;
    slot_ = static_cast<int>(i);
  }
}

TemporaryName::~TemporaryName() {
  if (slot_ >= 0) slots[static_cast<size_t>(slot_)].state = State::kFree;
}

void removeTemporaries() noexcept {
  for (const Slot& slot : slots)
    if (slot.state == State::kSet) unlink(slot.path.data());
}

}  // namespace sluice
