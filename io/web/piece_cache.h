// PieceCache: pieces of objects of web servers in a folder of this machine, under a hard limit.
//
// A piece is a file: its name, the object's stamp (ETag or Last-Modified), a checksum, its bytes.
// Several processes may share the folder. Files appear whole under their names or not at all, so a
// process that is killed leaves no wrong piece; what it was writing is removed when room is made.
// The bytes of all files, rounded up to whole blocks of 4096, never exceed the limit: each writer
// takes its part of it, under a lock, before it writes. Pieces that were not used for longest make
// room for others. Any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "src/base/files/descriptor.h"

namespace sluice {

// A file of the cache, open: it can be read even if it is removed meanwhile.
class CachedPiece {
 public:
  CachedPiece(Descriptor file, std::string stamp, uint64_t whole, uint64_t bytes, uint64_t checksum)
      : file_(std::move(file)),
        stamp_(std::move(stamp)),
        whole_(whole),
        bytes_(bytes),
        checksum_(checksum) {}

  const std::string& stamp() const { return stamp_; }
  uint64_t wholeBytes() const { return whole_; }  // of the object that it is a piece of
  uint64_t bytes() const { return bytes_; }
  // Once. False: it is damaged, or `out` has not its size.
  bool read(std::span<std::byte> out) const;

 private:
  Descriptor file_;  // positioned at the bytes
  std::string stamp_;
  uint64_t whole_, bytes_, checksum_;
};

class PieceCache {
 public:
  // Makes the folder, for its owner alone. Throws Error: it has no name, or cannot be written.
  PieceCache(std::filesystem::path folder, uint64_t budget_bytes);

  // The piece that was kept under a name; damaged ones are removed.
  std::optional<CachedPiece> find(const std::string& name);
  // Keeps a piece in the place of another one of its name. Without effect if the limit has no room
  // for it, or if another thread or process is keeping it. Returns the folder and the reason if it
  // cannot be written: the disk is full, the folder is closed.
  std::optional<std::string> keep(const std::string& name, const std::string& stamp, uint64_t whole,
                                  std::span<const std::byte> bytes);
  void remove(const std::string& name);

 private:
  std::filesystem::path fileOf(const std::string& name) const;
  // A new file of this size, counted already; nothing: no room, or another one is writing it.
  // Throws Error: it cannot be written.
  Descriptor reserve(const std::filesystem::path& replaced, const std::filesystem::path& temporary,
                     uint64_t bytes);
  // Removes what was not used for longest until at most `most` bytes are left. Returns these.
  uint64_t shrinkTo(uint64_t most);

  const std::filesystem::path folder_;
  const uint64_t budget_;
};

}  // namespace sluice
