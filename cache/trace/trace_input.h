// TraceInput: a trace file's bytes, a large block at a time, as lines, bytes or records of a fixed
// size. The returned views live until the next call. It holds one block of memory, whatever the
// file's size; a line longer than any trace's is rejected. One thread.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace sluice::trace_internal {

class TraceInput {
 public:
  static constexpr size_t kLongestLine = 1 << 16;

  // `label` starts the errors' lines.
  TraceInput(std::unique_ptr<std::istream> in, std::string label);

  // The next line without its end ("\n" or "\r\n"); false at the end. Throws Error for a line of
  // more than kLongestLine bytes, and if reading fails.
  bool line(std::string_view& line);
  // The number of the line read last, from 1.
  uint64_t lineNumber() const { return line_number_; }
  // Whether the line read last had its end; without it the file may have been cut there.
  bool lineEnded() const { return line_ended_; }

  // The next byte, or -1 at the end.
  int byte() {
    if (at_ == end_ && !refill()) return -1;
    return static_cast<uint8_t>(block_[at_++]);
  }
  // The next `count` bytes or, at the end, the fewer that are left. Requires: count within a block.
  std::string_view bytes(size_t count);

  const std::string& label() const { return label_; }

 private:
  // Reads more bytes behind the unread ones; false when there are none.
  bool refill();

  const std::unique_ptr<std::istream> in_;
  const std::string label_;
  std::vector<char> block_;
  size_t at_ = 0, end_ = 0;  // the unread part of the block
  uint64_t line_number_ = 0;
  bool line_ended_ = true;
};

// Eight characters as a word, the first in its low byte.
inline uint64_t wordOf(const char* eight) {
  uint64_t word = 0;
  std::memcpy(&word, eight, sizeof word);
  return word;
}
inline bool areDigits(uint64_t word) {
  constexpr uint64_t kHigh = 0xf0f0f0f0f0f0f0f0u, kSix = 0x0606060606060606u;
  // '0' to '9' are 0x30 to 0x39: 3 above, also when six is added below.
  return ((word & kHigh) | ((word + kSix) & kHigh) >> 4) == 0x3333333333333333u;
}
// The value of eight digits, combined to pairs, then fours, then all of them. Requires:
// areDigits(word).
inline uint64_t numberOf(uint64_t word) {
  static_assert(std::endian::native == std::endian::little);
  word -= 0x3030303030303030u;
  word = (word * 10 + (word >> 8)) & 0x00ff00ff00ff00ffu;
  word = (word * 100 + (word >> 16)) & 0x0000ffff0000ffffu;
  return (word * 10000 + (word >> 32)) & 0xffffffffu;
}

// Takes a whole number off the front of `text`: false, and `text` somewhere in it, when there is
// none or it is 2^64 or more.
inline bool takeNumber(std::string_view& text, uint64_t& value) {
  constexpr size_t kSafeDigits = 19;  // any number of so many digits is below 2^64
  const auto digitAt = [&](size_t at) { return static_cast<unsigned>(text[at] - '0'); };
  size_t at = 0;
  uint64_t sum = 0;
  for (; at < 16 && text.size() - at >= 8; at += 8) {
    const uint64_t word = wordOf(text.data() + at);
    if (!areDigits(word)) break;
    sum = sum * 100'000'000 + numberOf(word);
  }
  const size_t safe = std::min(text.size(), kSafeDigits);
  for (; at < safe && digitAt(at) <= 9; ++at) sum = sum * 10 + digitAt(at);
  for (; at >= kSafeDigits && at < text.size() && digitAt(at) <= 9; ++at) {
    const unsigned digit = digitAt(at);
    if (sum > UINT64_MAX / 10 || sum * 10 > UINT64_MAX - digit) return false;
    sum = sum * 10 + digit;
  }
  text.remove_prefix(at);
  value = sum;
  return at > 0;
}

// Takes `c` off the front of `text`; false when it does not start with it.
inline bool takeCharacter(std::string_view& text, char c) {
  if (text.empty() || text.front() != c) return false;
  text.remove_prefix(1);
  return true;
}

// Takes spaces and tabs off the front, if there are any.
inline void skipSpaces(std::string_view& text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
}

// Takes whole numbers with single spaces between them into `values`, as many as it has.
template <class Numbers>
bool takeNumbers(std::string_view& text, Numbers& values) {
  for (size_t i = 0; i < values.size(); ++i)
    if ((i > 0 && !takeCharacter(text, ' ')) || !takeNumber(text, values[i])) return false;
  return true;
}

}  // namespace sluice::trace_internal
