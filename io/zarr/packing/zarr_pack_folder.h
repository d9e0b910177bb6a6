// ZarrPackFolder: an unfinished pack on disk, DIR.zarr.partial in the folder of the DIR.zarr that
// it becomes.
//
// The folder holds the future store ("store"), a lock against a second process ("lock"), the volume
// and the options that are packed ("pack.json"), and a journal of the chunks that are done, with
// the checksum of each ("journal"). The store has several arrays, whose chunks are numbered
// through.
//
// A chunk is written under another name and renamed, then noted in the journal. Whoever opens the
// folder again believes the journal only if the chunk's file has the noted length and checksum, so
// that a kill or a power cut at any moment costs chunks and never makes a wrong one
// (zarr_pack_recovery.cpp). Chunks of an array of shards are appended to their shard's file in the
// order in which they come, and the journal has their offsets; complete() puts the indices behind
// them. Only finish() gives the store its name. Any thread may call write(), and isDone() of a
// chunk that no other thread writes; one thread calls the others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/zarr/metadata/zarr_array.h"
#include "io/zarr/metadata/zarr_text.h"
#include "io/zarr/packing/pack_journal.h"
#include "io/zarr/reading/zarr_checksums.h"
#include "src/base/files/descriptor.h"
#include "src/base/threads/mutex.h"
#include "src/base/threads/progress_meter.h"
#include "src/base/threads/stop_token.h"
#include "src/base/threads/worker_pool.h"

namespace sluice {

// An array of a store: a level of the volume, or its spreads.
struct PackedArray {
  std::string folder;  // in the store: "0", "1", "spread/1"
  ZarrArray array;
};

// Whether an unfinished store of another volume or of other parameters is refused or replaced.
enum class BegunByOthers { kRefuse, kReplace };

struct FinishOptions {
  bool replace = false;  // an older store of that name
  bool sync = true;      // after a power cut the store is whole; without, its checksums may fail
};

class ZarrPackFolder {
 public:
  // Opens or makes the folder of `output`. `arrays`: of the store. `parameters` (one text) says
  // what is packed and how. Throws Error: another process packs to there, the folder is of another
  // volume or other parameters and not to be replaced (the line says what to do), it cannot be
  // written.
  ZarrPackFolder(const std::filesystem::path& output, std::vector<PackedArray> arrays,
                 const std::string& source_identity, const std::string& parameters,
                 BegunByOthers others = BegunByOthers::kRefuse);
  ZarrPackFolder(const ZarrPackFolder&) = delete;
  ZarrPackFolder& operator=(const ZarrPackFolder&) = delete;

  // Reads the journal and checks each chunk's file against it, on all threads. Returns how many
  // chunks are done, empty ones included. Called once, before the following.
  int64_t recover(WorkerPool& pool, ProgressMeter& progress, const StopToken& stop);
  // The number of the first chunk of an array; of one more than there are, of all chunks.
  int64_t firstChunk(size_t array) const { return first_chunks_[array]; }
  bool isDone(int64_t chunk) const { return done_[static_cast<size_t>(chunk)]; }

  // Takes the stored bytes of a chunk; none for a chunk that is all fill value. Each thread gives a
  // number of its own. Throws Error; if the system failed, as on a full disk, it says how to go on.
  // So do the next two.
  void write(int64_t chunk, std::span<const std::byte> stored, int thread);

  // With the metadata in place the store can be opened, to be verified. Requires: all chunks done.
  // `array_texts`: of each array.
  std::filesystem::path complete(const std::string& group_text, const std::string& image_text,
                                 const std::vector<ZarrArrayTexts>& array_texts);
  // Brings all to the disk and the store to its name; the folder goes. Throws Error.
  void finish(const FinishOptions& options);

  // Removes what was written. Nothing else may be called after it.
  void discard();

  const std::vector<StoredChunk>& chunks() const { return chunks_; }
  // Memory of the tables for an array's chunks.
  static uint64_t tableBytes(const ZarrArray& array);
  // Files that hold chunks. Requires: complete() was called.
  int64_t chunkFiles() const;
  const std::filesystem::path& path() const { return folder_; }

 private:
  // Behind the stored bytes of a chunk in a shard, and behind the shard's index.
  static constexpr uint64_t kShardCrcBytes = sizeof(uint32_t);

  // Makes a folder and those above it. Throws Error.
  static void makeFolders(const std::filesystem::path& path);
  // Locks the folder against other processes. Throws Error if one packs to it.
  void lock();
  // Compares the unfinished store with these parameters, or notes them in a new folder. Throws
  // Error, see the constructor.
  void checkParameters(const std::string& source_identity, const std::string& parameters,
                       BegunByOthers others);
  // Whether the chunk's file has the bytes that the journal notes.
  bool checkChunk(int64_t chunk) const;
  // The array that a chunk belongs to.
  size_t arrayOf(int64_t chunk) const;
  std::filesystem::path chunkPath(int64_t chunk) const;
  bool hasShards() const { return arrays_.front().array.shards.has_value(); }
  // The number of a chunk's shard among those of all arrays.
  size_t shardOf(int64_t chunk) const;
  void store(int64_t chunk, std::span<const std::byte> stored, int thread);
  void append(int64_t chunk, std::span<const std::byte> stored, uint64_t offset);
  // Puts the index of each shard of an array behind its chunks.
  void writeIndices(size_t array);
  // Writes all metadata.
  void describe(const std::string& group_text, const std::string& image_text,
                const std::vector<ZarrArrayTexts>& array_texts);
  void putInPlace(const FinishOptions& options);

  const std::filesystem::path output_, folder_, store_;
  const std::vector<PackedArray> arrays_;
  const std::vector<int64_t> first_chunks_, first_files_;
  Descriptor lock_;                     // constant once open
  std::optional<PackJournal> journal_;  // there once the folder is ours; guarded by mutex_
  Mutex mutex_;                         // guards the journal and the members below
  std::vector<StoredChunk> chunks_;     // guarded by mutex_, an element a chunk
  std::vector<char> done_;              // guarded by mutex_, read between loops only
  // With shards: the offset of each chunk in its file, and the end of the chunks of each file.
  std::vector<uint64_t> offsets_, ends_;  // guarded by mutex_
};

}  // namespace sluice
