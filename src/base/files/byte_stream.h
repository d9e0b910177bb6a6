// Plain values and lists of them as bytes, one after another, in the machine's own order: the
// format of files that we write for ourselves. A reader never reads beyond the end, nor takes more
// memory for a list than its bytes do, whatever a file contains.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "src/base/memory/large_pages.h"

namespace sluice {

class ByteWriter {
 public:
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(std::as_bytes(std::span(&v, 1)));
  }
  // Writes a list with its length in front.
  template <class T>
  void list(const std::vector<T>& v) {
    value<uint64_t>(v.size());
    append(std::as_bytes(std::span(v)));
  }
  std::vector<std::byte> bytes;

 private:
  void append(std::span<const std::byte> raw) {
    const size_t at = bytes.size();
    bytes.resize(at + raw.size());
    if (!raw.empty()) std::memcpy(bytes.data() + at, raw.data(), raw.size());
  }
};

class ByteReader {
 public:
  // `bytes` must outlive it.
  explicit ByteReader(std::span<const std::byte> bytes) : left_(bytes) {}

  // False, and `v` unchanged, if too little is left.
  template <class T>
  bool value(T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (left_.size() < sizeof v) return false;
    std::memcpy(&v, left_.data(), sizeof v);
    left_ = left_.subspan(sizeof v);
    return true;
  }
  template <class T>
  bool list(std::vector<T>& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    uint64_t count = 0;
    if (!value(count) || count > left_.size() / sizeof(T)) return false;
    reserveLarge(v, count);
    v.resize(count);
    if (count > 0) std::memcpy(v.data(), left_.data(), count * sizeof(T));
    left_ = left_.subspan(count * sizeof(T));
    return true;
  }
  std::span<const std::byte> left() const { return left_; }

 private:
  std::span<const std::byte> left_;
};

}  // namespace sluice
