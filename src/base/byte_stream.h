// Plain values and lists of them as bytes, one after another, in the machine's own order: what
// files that we write for ourselves consist of. A reader never reads beyond what is left, nor takes
// more memory for a list than its bytes do, whatever a file says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "src/base/large_pages.h"

namespace sluice {

class ByteWriter {
 public:
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(std::as_bytes(std::span(&v, 1)));
  }
  // With its length in front.
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

  // False, and `v` as it was, where too little is left.
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
