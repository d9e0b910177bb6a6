// ChunkedArray: the chunks of one stored array, whatever the format: which there are, and their
// voxels. ChunkedVolume: an image of such arrays, its levels. Readers of chunked formats make
// these; ChunkedSource (chunked_source.h) cuts boxes out of them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/zarr/metadata/zarr_array.h"
#include "io/zarr/metadata/zarr_image.h"
#include "io/zarr/reading/zarr_chunk_cache.h"
#include "src/base/sources/stored_reads.h"

namespace sluice {

// Any thread may call anything at once.
class ChunkedArray {
 public:
  virtual ~ChunkedArray() = default;

  // Shape, chunks and voxels. Constant.
  virtual const ZarrArray& array() const = 0;

  // Whether existing() knows the files.
  virtual bool areKnown() const = 0;
  // The numbers of the files that there are, ascending. Requires: areKnown(). Throws Error.
  virtual const std::vector<int64_t>& existing() = 0;
  // Whether a chunk is stored; perhaps also true if files are not known. Throws Error.
  virtual bool exists(int64_t chunk) = 0;

  // The voxels of a chunk in this machine's byte order; null: it turned out not to be there. Takes
  // at most twice its size from `memory` meanwhile. Requires: exists(chunk). Throws Error.
  virtual std::shared_ptr<CountedBytes> load(int64_t chunk, ChunkMemory& memory) = 0;

  // The cost of reading each of these chunks, without their decoding. Neither chunks nor indices
  // are read for it. Requires: ascending, each once. Throws Error as existing() does.
  virtual StoredReads storedReads(std::span<const int64_t> chunks) {
    StoredReads reads;
    reads.chunks = static_cast<int64_t>(chunks.size());
    reads.most_bytes = chunks.size() * array().chunkBytes();
    return reads;
  }

  // A text that changes whenever a chunk may have changed.
  virtual std::string stamp() const = 0;
  virtual uint64_t storedBytesRead() const = 0;
  // See VolumeSource::distantReads().
  virtual int distantReads() const { return 0; }

  // The memory that a thread holds of an index of chunks; 0: there is none to be read.
  virtual uint64_t indexBytes() const { return 0; }
  // The limit for all that are kept.
  virtual void holdIndices(uint64_t /*bytes*/) {}
};

// An array, and what was read to open it.
struct OpenedArray {
  std::unique_ptr<ChunkedArray> array;
  std::string identity;             // a line that changes when its metadata do
  std::vector<std::string> places;  // files and folders, as VolumeSource::files() has them
  uint64_t header_bytes = 0;        // read of its metadata
};

// A volume, and the way to its arrays.
struct ChunkedVolume {
  std::string name;   // in messages
  std::string title;  // the layout's name
  ZarrImage image;
  std::string said_by;                          // the file that names the axes, in messages
  bool is_image = false;                        // level 0 of several, see `image`
  std::vector<std::string> identities, places;  // of what was read so far
  std::vector<std::string> notes;               // for people, one line each
  uint64_t header_bytes = 0;

  // The array of a level. Throws Error.
  std::function<OpenedArray(size_t level)> open;
  // The spreads of a level; nullopt: it has none. Empty: no level has.
  std::function<std::optional<OpenedArray>(size_t level)> open_spreads;
  // A level of the group of this number among image.level_groups. Throws Error.
  std::function<OpenedArray(size_t group, size_t level)> open_in_group;
};

}  // namespace sluice
