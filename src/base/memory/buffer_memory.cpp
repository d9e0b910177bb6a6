#include "src/base/memory/buffer_memory.h"

#include <sys/mman.h>

#include <algorithm>
#include <iterator>

#include "src/base/memory/large_pages.h"

namespace sluice {
namespace {

constexpr uint64_t kPage = 4096;
// Addresses are free; with twice as many as bytes, pieces of several sizes find a place.
constexpr uint64_t kAddressesPerByte = 2;

uint64_t roundedUp(uint64_t bytes) {
  return (bytes + kPage - 1) / kPage * kPage;
}

}  // namespace

void BufferMemory::Extents::add(uint64_t at, uint64_t length) {
  auto next = lengths_.lower_bound(at);
  if (next != lengths_.end() && at + length == next->first) {
    length += next->second;
    next = lengths_.erase(next);
  }
  if (next != lengths_.begin()) {
    const auto before = std::prev(next);
    if (before->first + before->second == at) {
      before->second += length;
      return;
    }
  }
  lengths_.emplace_hint(next, at, length);
}

std::optional<uint64_t> BufferMemory::Extents::take(uint64_t length) {
  const auto found =
      std::ranges::find_if(lengths_, [&](const auto& extent) { return extent.second >= length; });
  if (found == lengths_.end()) return std::nullopt;
  const auto [at, had] = *found;
  const auto next = lengths_.erase(found);
  if (had > length) lengths_.emplace_hint(next, at + length, had - length);
  return at;
}

BufferMemory::Extents::Part BufferMemory::Extents::takeLast(uint64_t most) {
  const auto last = std::prev(lengths_.end());
  const Part part{last->first + last->second - std::min(most, last->second),
                  std::min(most, last->second)};
  last->second -= part.length;
  if (last->second == 0) lengths_.erase(last);
  return part;
}

uint64_t BufferMemory::Extents::bytes() const {
  uint64_t sum = 0;
  for (const auto& [at, length] : lengths_) sum += length;
  return sum;
}

std::shared_ptr<BufferMemory> BufferMemory::make(uint64_t limit_bytes) {
  return std::shared_ptr<BufferMemory>(new BufferMemory(limit_bytes));
}

BufferMemory::BufferMemory(uint64_t limit_bytes) : limit_bytes_(limit_bytes) {
  // Without addresses, which a limit on them may deny, the allocator provides the memory.
  const uint64_t bytes = roundedUp(limit_bytes) * kAddressesPerByte;
  void* const mapped = mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                            // Without reserving: the kernel counts only pages that are touched.
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (bytes == 0 || mapped == MAP_FAILED) return;
  const MutexLock lock(mutex_);
  begin_ = static_cast<std::byte*>(mapped);
  mapped_bytes_ = bytes;
  // Beyond the limit, large pages would exceed it.
  preferLargePages({begin_, limit_bytes});
  empty_.add(0, bytes);
}

BufferMemory::~BufferMemory() {
  if (begin_ != nullptr) munmap(begin_, mapped_bytes_);
}

BufferMemory::Piece BufferMemory::take(size_t bytes) {
  if (bytes >= kLeastBytes) {
    const uint64_t length = roundedUp(bytes);
    if (const std::optional<uint64_t> at = takeExtent(length))
      // A piece keeps the memory itself alive, whoever lets go of it last.
      return {begin_ + *at, [self = shared_from_this(), at = *at, length](std::byte*) {
                self->giveBack(at, length);
              }};
  }
  return std::make_shared_for_overwrite<std::byte[]>(bytes);
}

std::optional<uint64_t> BufferMemory::takeExtent(uint64_t length) {
  const MutexLock lock(mutex_);
  // Idle pages are in memory already: using them again takes no page fault.
  if (const std::optional<uint64_t> at = idle_.take(length)) return at;
  makeRoom(length);
  const std::optional<uint64_t> at = empty_.take(length);
  if (at) held_bytes_ += length;
  return at;
}

void BufferMemory::makeReady(uint64_t bytes) {
  std::optional<uint64_t> at;
  uint64_t length = 0;
  {
    const MutexLock lock(mutex_);
    const uint64_t idle = idle_.bytes();
    if (idle >= bytes) return;
    length = roundedUp(bytes - idle);
    if (held_bytes_ + length > limit_bytes_) return;
    at = empty_.take(length);
    if (!at) return;
    held_bytes_ += length;
  }
  // Without the lock: others take pieces meanwhile.
  for (uint64_t page = 0; page < length; page += kPage) begin_[*at + page] = std::byte{0};
  giveBack(*at, length);
}

void BufferMemory::makeRoom(uint64_t length) {
  while (held_bytes_ + length > limit_bytes_ && !idle_.empty()) {
    const Extents::Part part = idle_.takeLast(roundedUp(held_bytes_ + length - limit_bytes_));
    // The addresses stay, the pages go back to the system and read as zeros.
    madvise(begin_ + part.at, part.length, MADV_DONTNEED);
    empty_.add(part.at, part.length);
    held_bytes_ -= part.length;
  }
}

void BufferMemory::setLimit(uint64_t limit_bytes) {
  const MutexLock lock(mutex_);
  limit_bytes_ = limit_bytes;
  makeRoom(0);
}

void BufferMemory::giveBack(uint64_t at, uint64_t length) {
  const MutexLock lock(mutex_);
  idle_.add(at, length);
}

uint64_t BufferMemory::heldBytes() const {
  const MutexLock lock(mutex_);
  return held_bytes_;
}

}  // namespace sluice
