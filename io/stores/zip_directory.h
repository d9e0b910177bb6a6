// The list of files in a zip file, which it has at its end: where each lies, and how it is stored.
// PKWARE's APPNOTE.TXT, 4.3: the central directory, and its form of 64 bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "io/files/file.h"

namespace sluice {

// Whether the first bytes of a file are those of a zip file.
bool isZip(std::string_view head);

struct ZipEntry {
  std::string_view name;  // as it stands in the zip file
  std::string_view key;   // the same without "./" or "/" in front; '/' between its parts
  bool is_deflated = false;
  uint32_t checksum = 0;                 // CRC-32 of the decoded bytes
  uint64_t stored_bytes = 0, bytes = 0;  // in the zip file, and decoded
  uint64_t header_at = 0;                // of the entry's own header, in the zip file
};

// Where the entry's bytes begin in the zip file. Throws Error: its own header is damaged, or that
// of another entry.
uint64_t contentOf(File& file, const ZipEntry& entry);

// Constant after construction. Takes the memory of the directory and eight bytes an entry.
class ZipDirectory {
 public:
  static constexpr uint64_t kMostBytes = 32 << 20;

  // Throws Error: the directory is damaged or longer than kMostBytes, the zip file has several
  // parts, or an entry is encrypted or neither stored nor deflated.
  explicit ZipDirectory(File& file);

  // Entries are in the order of their keys, each key once: the last that was written. Folders have
  // no entry.
  size_t size() const { return entries_.size(); }
  ZipEntry at(size_t i) const { return entryAt(entries_[i]); }
  // The first entry whose key is not less.
  size_t firstFrom(std::string_view key) const;
  std::optional<ZipEntry> find(std::string_view key) const;

 private:
  ZipEntry entryAt(uint64_t offset) const;

  std::vector<std::byte> bytes_;
  std::vector<uint64_t> entries_;  // where they begin in bytes_
};

}  // namespace sluice
