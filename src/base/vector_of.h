// VectorOf: a vector of numbers as the compiler knows it, of so many bytes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sluice {

// GCC takes no vectors of a type that a template leaves open.
template <class T, size_t kBytes>
struct VectorOf;
template <size_t kBytes>
struct VectorOf<uint8_t, kBytes> {
  using Type [[gnu::vector_size(kBytes)]] = uint8_t;
};
template <size_t kBytes>
struct VectorOf<uint16_t, kBytes> {
  using Type [[gnu::vector_size(kBytes)]] = uint16_t;
};
template <size_t kBytes>
struct VectorOf<float, kBytes> {
  using Type [[gnu::vector_size(kBytes)]] = float;
};

}  // namespace sluice
