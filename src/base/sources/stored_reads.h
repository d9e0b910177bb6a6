// StoredReads: what reading boxes of voxels takes from a store of chunks, before a chunk is read.
//
// A source that reads a folder, a web server or a file chunk by chunk implements StoredSource, so
// that `plan` can tell the cost of a picture from the metadata alone.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "src/base/sources/volume_source.h"

namespace sluice {

// A plain value. Each chunk and each index of a shard counts once.
struct StoredReads {
  int64_t chunks = 0;
  int64_t indices = 0;      // of shards
  int64_t kept = 0;         // of both: those of which a cache on this machine has a copy
  uint64_t most_bytes = 0;  // of the others, at most: compressed chunks have a bound only
  // The most times that chunks are decoded: each once if the memory holds all of them, else once
  // for each box that needs it. And the memory that they take decoded.
  int64_t decodes = 0;
  uint64_t decoded_bytes = 0;

  int64_t requests() const { return chunks + indices; }
  StoredReads& operator+=(const StoredReads& more) {
    chunks += more.chunks;
    indices += more.indices;
    kept += more.kept;
    most_bytes += more.most_bytes;
    decodes += more.decodes;
    decoded_bytes += more.decoded_bytes;
    return *this;
  }
};

// A box that will be read of a level of a volume, or of its spreads; null: of level 0.
struct LevelBox {
  const VolumeSource* level = nullptr;
  Box3 box;
};

class StoredSource {
 public:
  virtual ~StoredSource() = default;
  // The cost of reading these boxes of a time step, each once, with `held_bytes` of decoded chunks
  // kept in memory. Boxes of levels that are not the source's own cost nothing.
  // nullopt: nothing is known. Neither chunks nor indices are read, except for copies on this
  // machine. Throws Error: a folder cannot be listed. Any thread.
  virtual std::optional<StoredReads> storedReads(int64_t time, std::span<const LevelBox> boxes,
                                                 uint64_t held_bytes) = 0;
};

// The same of any source; nullopt: it does not read chunks.
inline std::optional<StoredReads> storedReads(VolumeSource& source, int64_t time,
                                              std::span<const LevelBox> boxes,
                                              uint64_t held_bytes) {
  auto* stored = dynamic_cast<StoredSource*>(&source);
  return stored == nullptr ? std::nullopt : stored->storedReads(time, boxes, held_bytes);
}

}  // namespace sluice
