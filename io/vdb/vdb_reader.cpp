#include "io/vdb/vdb_reader.h"

#include <cstring>

#include "src/base/error.h"

namespace sluice {

void VdbReader::read(void* to, uint64_t bytes) {
  need(bytes);
  if (bytes > kWindowBytes) {
    file_.readAt(position_, {static_cast<std::byte*>(to), bytes});
  } else {
    if (position_ < window_at_ || position_ + bytes > window_at_ + window_size_) {
      window_at_ = position_;
      window_size_ = file_.readSome(position_, window_);
      if (window_size_ < bytes) fail("{}: the file became shorter while it was read", path());
    }
    std::memcpy(to, window_.data() + (position_ - window_at_), bytes);
  }
  position_ += bytes;
}

std::string VdbReader::text() {
  const auto bytes = number<uint32_t>();
  need(bytes);
  std::string value(bytes, '\0');
  read(value.data(), bytes);
  return value;
}

void VdbReader::skip(uint64_t bytes) {
  need(bytes);
  position_ += bytes;
}

void VdbReader::seek(uint64_t position) {
  position_ = 0;
  skip(position);
}

void VdbReader::need(uint64_t bytes) const {
  if (bytes > size() - position_)
    fail("{}: OpenVDB file cut short or damaged: it needs {} bytes at {} but has {}", path(), bytes,
         position_, size());
}

}  // namespace sluice
