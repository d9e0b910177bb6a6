// Decoder: the bytes that an encoded stream in a file stands for, from its start to its end.
#pragma once

#include <cstddef>
#include <span>

namespace sluice {

class Decoder {
 public:
  virtual ~Decoder() = default;

  // Fills `out`, whose size is a multiple of 8; returns fewer bytes only if the stream ends. Throws
  // Error (path, offset, reason) when the stream is damaged.
  virtual size_t read(std::span<std::byte> out) = 0;

  // Whether the stream ended by its own mark; false after a short read: the file breaks off.
  virtual bool finished() const = 0;
};

}  // namespace sluice
