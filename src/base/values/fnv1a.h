// The 64-bit FNV-1a hash. Names and keys of files are made of it, so its values may not change.
// Data that is compared within one version has the faster Digest (digest.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace sluice {

inline constexpr uint64_t kFnv1aStart = 0xcbf29ce484222325;

// The hash of the bytes behind those of which `before` is the hash.
inline uint64_t fnv1a(std::span<const std::byte> bytes, uint64_t before = kFnv1aStart) {
  for (const std::byte byte : bytes)
    before = (before ^ static_cast<uint64_t>(byte)) * 0x100000001b3;
  return before;
}
inline uint64_t fnv1a(std::string_view text, uint64_t before = kFnv1aStart) {
  return fnv1a(std::as_bytes(std::span(text)), before);
}

}  // namespace sluice
