#include "io/headers/text_voxels.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include "io/headers/header_fields.h"
#include "src/base/error.h"

namespace sluice {
namespace {

constexpr size_t kMaxTokenBytes = 64;

bool separates(char c) {
  return c == ' ' || c == ',' || (c >= '\t' && c <= '\r');
}

}  // namespace

TextVoxels::TextVoxels(std::shared_ptr<File> file, uint64_t offset, VoxelType type, uint64_t end)
    : file_(std::move(file)), type_(type), text_end_(end), offset_(offset) {}

// Moves the unread part to the front and reads on behind it; false when the file has no more.
bool TextVoxels::refill() {
  std::memmove(text_.data(), text_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  const uint64_t left = text_end_ - std::min(offset_, text_end_);
  const auto room = std::span(text_).subspan(end_);
  const size_t taken = file_->readSome(
      offset_, std::as_writable_bytes(room.first(std::min<uint64_t>(room.size(), left))));
  offset_ += taken;
  end_ += taken;
  return taken > 0;
}

std::string_view TextVoxels::nextToken() {
  do {
    while (begin_ < end_ && separates(text_[begin_])) ++begin_;
  } while (begin_ == end_ && refill());
  size_t length = 0;
  for (;;) {
    while (begin_ + length < end_ && !separates(text_[begin_ + length])) ++length;
    // A number may be cut by the end of what was read, so that more is read first.
    if (begin_ + length < end_ || length > kMaxTokenBytes || !refill()) break;
  }
  const std::string_view token(text_.data() + begin_, length);
  begin_ += length;
  return token;
}

size_t TextVoxels::read(std::span<std::byte> out) {
  return visitVoxelType(type_, [&](auto tag) {
    size_t got = 0;
    while (got + sizeof(tag) <= out.size()) {
      const std::string_view token = nextToken();
      if (token.empty()) break;
      const char* const begin = token.data() + (token[0] == '+' ? 1 : 0);
      const char* const end = token.data() + token.size();
      const auto [stop, status] = std::from_chars(begin, end, tag);
      if (status != std::errc() || stop != end || token.size() > kMaxTokenBytes)
        fail("{}: {} before offset {} is no {} value", file_->path(), inQuotes(token),
             offset_ - (end_ - begin_), name(type_));
      std::memcpy(out.data() + got, &tag, sizeof(tag));
      got += sizeof(tag);
    }
    return got;
  });
}

}  // namespace sluice
