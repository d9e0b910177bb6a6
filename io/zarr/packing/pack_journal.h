// PackJournal: the chunks of an unfinished pack that are done, in a file that a kill or a power cut
// leaves readable: each record has a checksum of its own, and what follows a damaged one is
// dropped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "src/base/files/descriptor.h"

namespace sluice {

// A chunk that is done. Plain values, as they lie in the file.
struct PackRecord {
  uint64_t chunk = 0;
  uint64_t bytes = 0, checksum = 0;  // as stored; 0: all fill value
  uint64_t offset = 0;               // in the file of a shard
};

class PackJournal {
 public:
  // Opens or makes the file. Throws Error.
  explicit PackJournal(const std::filesystem::path& path);

  // The sound records, in the order in which they were added; the file is cut behind the last one.
  // Called once, before add(). Throws Error.
  std::vector<PackRecord> recover(uint64_t chunks);
  // One thread at a time. Throws Error (a full disk too).
  void add(const PackRecord& record);

 private:
  const std::filesystem::path path_;
  const Descriptor file_;
};

// writeAll() to a part of an unfinished pack, whose error names `path`.
void writePart(int file, std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace sluice
