// ByteStore: bytes at positions: a file (File), or the decoded bytes of a compressed one
// (DecodedFile).
//
// RawSource reads voxels out of one without knowing which it is. Every member may be called from
// any thread at once.
#pragma once

#include <sys/uio.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sluice {

class ByteStore {
 public:
  virtual ~ByteStore() = default;

  // Fills `parts`, one after the other, with the bytes from `offset` on. At most kMaxParts parts.
  // Throws Error when there are fewer bytes, and when they cannot be had.
  virtual void read(uint64_t offset, std::span<const iovec> parts) = 0;

  // `bytes` from `offset` on are read next: a disk may begin with them. Never fails.
  virtual void expectRead(uint64_t /*offset*/, uint64_t /*bytes*/) {}

  // Whether the first read takes as long as reading all of it.
  virtual bool isOneStream() const { return false; }

  // The bytes that are decoded together, so that one costs as much as all; 1: each is read alone.
  virtual uint64_t unitBytes() const { return 1; }
  // The same as the members of VolumeSource of these names.
  virtual uint64_t heldBytesAThread() const { return 0; }
  virtual void holdAtMost(uint64_t /*bytes*/) {}

  // Bytes taken from the file itself so far: compressed bytes of a compressed file.
  virtual uint64_t storedBytesRead() const = 0;

  // The files that it is read from, as they were named.
  virtual std::vector<std::string> paths() const = 0;

  static constexpr size_t kMaxParts = 1024;  // Linux' IOV_MAX
};

// Fills `parts` (at most ByteStore::kMaxParts) from `offset` of an open file on; returns the bytes
// that the file had for them. Throws Error, which names `path`, when the system refuses.
uint64_t readParts(const std::string& path, int descriptor, uint64_t offset,
                   std::span<const iovec> parts);

}  // namespace sluice
