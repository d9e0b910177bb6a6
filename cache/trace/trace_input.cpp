#include "cache/trace/trace_input.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "src/base/error.h"

namespace sluice::trace_internal {
namespace {

constexpr size_t kBlockBytes = 1 << 18;

}  // namespace

TraceInput::TraceInput(std::unique_ptr<std::istream> in, std::string label)
    : in_(std::move(in)), label_(std::move(label)), block_(kBlockBytes) {}

bool TraceInput::refill() {
  // A line that began in the block stays whole.
  std::memmove(block_.data(), block_.data() + at_, end_ - at_);
  end_ -= at_;
  at_ = 0;
  in_->read(block_.data() + end_, static_cast<std::streamsize>(block_.size() - end_));
  const auto got = static_cast<size_t>(in_->gcount());
  if (in_->bad()) fail("{}: cannot read the trace", label_);
  end_ += got;
  return got > 0;
}

bool TraceInput::line(std::string_view& line) {
  size_t length = 0;
  const char* newline = nullptr;
  while (true) {
    newline = static_cast<const char*>(
        std::memchr(block_.data() + at_ + length, '\n', end_ - at_ - length));
    if (newline != nullptr) break;
    length = end_ - at_;
    // Bounded by the line's limit, which is shorter than the block.
    if (length > kLongestLine || !refill()) break;
  }
  if (newline == nullptr && length == 0) return false;
  ++line_number_;
  line_ended_ = newline != nullptr;
  if (newline != nullptr) length = static_cast<size_t>(newline - (block_.data() + at_));
  if (length > kLongestLine)
    fail("{}:{}: expected a line of at most {} bytes, found a longer one; is it a trace?", label_,
         line_number_, kLongestLine);
  line = {block_.data() + at_, length};
  at_ += length + (line_ended_ ? 1 : 0);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return true;
}

std::string_view TraceInput::bytes(size_t count) {
  SLUICE_CHECK_LE(count, kBlockBytes);
  while (end_ - at_ < count && refill()) {
  }
  const std::string_view taken(block_.data() + at_, std::min(count, end_ - at_));
  at_ += taken.size();
  return taken;
}

}  // namespace sluice::trace_internal
