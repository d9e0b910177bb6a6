#include "src/base/memory/buffer_memory.h"

#include <gtest/gtest.h>

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

namespace sluice {
namespace {

constexpr uint64_t kKiB = 1024, kMiB = kKiB * kKiB;

// Resident bytes of a piece, as the kernel counts them.
uint64_t residentBytes(const std::byte* piece, size_t bytes) {
  std::vector<unsigned char> pages(bytes / 4096);
  EXPECT_EQ(mincore(const_cast<std::byte*>(piece), bytes, pages.data()), 0);
  return 4096 * static_cast<uint64_t>(std::ranges::count_if(pages, [](auto p) { return p & 1; }));
}

TEST(BufferMemory, whatIsGivenBackIsTakenAgain) {
  const auto memory = BufferMemory::make(kMiB);
  const std::byte* first = memory->take(256 * kKiB).get();
  EXPECT_EQ(memory->take(256 * kKiB).get(), first);
  EXPECT_EQ(memory->take(100 * kKiB).get(), first) << "of any size that it has room for";
  EXPECT_EQ(memory->heldBytes(), 256 * kKiB);
}

TEST(BufferMemory, neighboursGivenBackMakeRoomForALargerPiece) {
  const auto memory = BufferMemory::make(kMiB);
  std::vector<BufferMemory::Piece> pieces;
  for (int i = 0; i < 4; ++i) pieces.push_back(memory->take(256 * kKiB));
  const std::byte* first = pieces[0].get();
  for (const size_t i : {2, 0, 3, 1}) pieces[i].reset();
  EXPECT_EQ(memory->take(kMiB).get(), first);
  EXPECT_EQ(memory->heldBytes(), kMiB);
}

TEST(BufferMemory, idleMemoryGoesBackWhereItWouldBeTooMuch) {
  const auto memory = BufferMemory::make(512 * kKiB);
  auto a = memory->take(256 * kKiB), b = memory->take(256 * kKiB);
  std::memset(a.get(), 1, 256 * kKiB);
  std::memset(b.get(), 1, 256 * kKiB);
  const std::byte* const at = a.get();
  EXPECT_EQ(residentBytes(at, 256 * kKiB), 256 * kKiB);
  a.reset();
  const auto larger = memory->take(260 * kKiB);  // does not fit into `a`'s place
  EXPECT_EQ(memory->heldBytes(), 516 * kKiB) << "what is in use is never taken away";
  EXPECT_EQ(residentBytes(at, 256 * kKiB), 0U);
}

TEST(BufferMemory, readyMemoryIsThereBeforeItIsTaken) {
  const auto memory = BufferMemory::make(kMiB);
  const std::byte* const first = memory->take(256 * kKiB).get();  // idle, and never written to
  memory->makeReady(512 * kKiB);
  EXPECT_EQ(memory->heldBytes(), 512 * kKiB) << "idle memory counts";
  const auto piece = memory->take(512 * kKiB);
  EXPECT_EQ(piece.get(), first);
  EXPECT_EQ(residentBytes(first + 256 * kKiB, 256 * kKiB), 256 * kKiB);
  memory->makeReady(600 * kKiB);
  EXPECT_EQ(memory->heldBytes(), 512 * kKiB) << "beyond the limit none is made ready";
}

TEST(BufferMemory, aLowerLimitTakesIdleMemoryAtOnce) {
  const auto memory = BufferMemory::make(kMiB);
  auto kept = memory->take(256 * kKiB);
  memory->take(768 * kKiB);
  EXPECT_EQ(memory->heldBytes(), kMiB);
  memory->setLimit(512 * kKiB);
  EXPECT_EQ(memory->heldBytes(), 512 * kKiB);
  memory->setLimit(0);
  EXPECT_EQ(memory->heldBytes(), 256 * kKiB) << "in use";
}

TEST(BufferMemory, piecesOutliveTheirOwner) {
  auto memory = BufferMemory::make(kMiB);
  const auto piece = memory->take(kMiB);
  memory.reset();
  std::memset(piece.get(), 7, kMiB);
  EXPECT_EQ(piece[kMiB - 1], std::byte{7});
}

TEST(BufferMemory, smallPiecesAndMoreThanTheLimitAreThereToo) {
  const auto memory = BufferMemory::make(0);
  const auto small = memory->take(1), large = memory->take(kMiB), none = memory->take(0);
  small[0] = large[kMiB - 1] = std::byte{1};
  EXPECT_EQ(memory->heldBytes(), 0U);
}

// Pieces of any sizes at random on several threads: none shares a byte with another, and idle
// memory never comes on top of the limit.
TEST(BufferMemory, piecesAreApartAndWithinTheLimit) {
  constexpr uint64_t kLimit = 24 * kMiB, kShare = kLimit / 4;
  const auto memory = BufferMemory::make(kLimit);
  std::vector<std::thread> threads;
  for (uint32_t thread = 0; thread < 4; ++thread)
    threads.emplace_back([&, thread] {
      struct Held {
        BufferMemory::Piece piece;
        size_t bytes;
        std::byte mark;
      };
      std::mt19937 random(thread);
      std::vector<Held> held;
      uint64_t in_use = 0;
      for (int i = 0; i < 2000; ++i) {
        const size_t bytes = 4096 * (16 + random() % 300);
        while (in_use + bytes > kShare) {
          const size_t at = random() % held.size();
          const auto& [piece, count, mark] = held[at];
          ASSERT_EQ(piece[0], mark);
          ASSERT_EQ(piece[count / 2], mark);
          ASSERT_EQ(piece[count - 1], mark);
          in_use -= count;
          std::swap(held[at], held.back());
          held.pop_back();
        }
        const auto mark = static_cast<std::byte>(random() % 256);
        held.push_back({memory->take(bytes), bytes, mark});
        for (const size_t at : {size_t{0}, bytes / 2, bytes - 1}) held.back().piece[at] = mark;
        in_use += bytes;
        ASSERT_LE(memory->heldBytes(), kLimit);
      }
    });
  for (std::thread& thread : threads) thread.join();
  // Memory that a thread used stays, even if the threads ran one after another.
  EXPECT_GT(memory->heldBytes(), kShare / 2);
}

}  // namespace
}  // namespace sluice
