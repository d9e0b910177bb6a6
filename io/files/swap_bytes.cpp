#include "io/files/swap_bytes.h"

#include <cstdint>
#include <cstring>

namespace sluice {
namespace {

template <class Word>
void swapWords(std::span<std::byte> bytes) {
  for (size_t i = 0; i + sizeof(Word) <= bytes.size(); i += sizeof(Word)) {
    Word word;
    std::memcpy(&word, bytes.data() + i, sizeof(Word));
    if constexpr (sizeof(Word) == 2) word = __builtin_bswap16(word);
    if constexpr (sizeof(Word) == 4) word = __builtin_bswap32(word);
    if constexpr (sizeof(Word) == 8) word = __builtin_bswap64(word);
    std::memcpy(bytes.data() + i, &word, sizeof(Word));
  }
}

}  // namespace

void swapBytes(std::span<std::byte> bytes, size_t word_bytes) {
  if (word_bytes == 2) swapWords<uint16_t>(bytes);
  if (word_bytes == 4) swapWords<uint32_t>(bytes);
  if (word_bytes == 8) swapWords<uint64_t>(bytes);
}

}  // namespace sluice
