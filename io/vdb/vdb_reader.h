// VdbReader: the bytes of an OpenVDB file in order, with every size checked against the remaining
// bytes.
//
// One thread; the file must outlive it. Small reads come out of a window of one page, so that a
// walk that skips most of a large file reads little more than it looks at.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "io/files/file.h"

namespace sluice {

class VdbReader {
 public:
  // All that follow throw Error if the file cannot be read or is too short.
  explicit VdbReader(File& file) : file_(file) {}

  const std::string& path() const { return file_.path(); }
  uint64_t size() const { return file_.sizeBytes(); }
  uint64_t position() const { return position_; }

  // Each moves the position behind what was read; seek() alone may go back.
  void read(void* to, uint64_t bytes);
  // A number as it lies in the file, which OpenVDB writes in little-endian order.
  template <class T>
  T number() {
    T value{};
    read(&value, sizeof value);
    return value;
  }
  // A string with its length in front.
  std::string text();
  void skip(uint64_t bytes);
  void seek(uint64_t position);

 private:
  static constexpr size_t kWindowBytes = 4096;
  void need(uint64_t bytes) const;

  File& file_;
  uint64_t position_ = 0;
  std::array<std::byte, kWindowBytes> window_{};
  uint64_t window_at_ = 0;
  size_t window_size_ = 0;
};

}  // namespace sluice
