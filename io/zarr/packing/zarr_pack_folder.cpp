#include "io/zarr/packing/zarr_pack_folder.h"

#include <fcntl.h>
#include <linux/fs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <utility>

#include "io/zarr/packing/free_name.h"
#include "io/zarr/reading/crc32c.h"
#include "src/base/error.h"
#include "src/base/files/atomic_file.h"
#include "src/base/files/suffixed_name.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

Descriptor openedFile(const fs::path& path, int flags) {
  Descriptor file(open(path.c_str(), flags | O_CLOEXEC, 0666));
  if (!file) failErrno(fmt::format("{}: cannot be opened", path.string()), errno);
  return file;
}

void renamePath(const fs::path& from, const fs::path& to) {
  if (rename(from.c_str(), to.c_str()) != 0)
    failErrno(fmt::format("{}: cannot be renamed to {}", from.string(), to.string()), errno);
}

// Files and the names of files. A folder on some network file systems cannot be synced: no error.
void syncFolder(const fs::path& folder, bool whole_file_system) {
  const Descriptor opened = openedFile(folder, O_RDONLY | O_DIRECTORY);
  if (!whole_file_system) {
    fsync(opened.get());
    return;
  }
  // One call for all files of a store, of which there may be millions.
  if (syncfs(opened.get()) != 0)
    failErrno(fmt::format("{}: cannot be brought to the disk", folder.string()), errno);
}

// Does a part of the work. If the system fails, all that was done stays, and the message says how
// to go on.
template <class Part>
auto resumably(const Part& part) {
  try {
    return part();
  } catch (const Error& error) {
    if (error.kind() != Error::Kind::kSystem) throw;
    failSystem("{}; make room if the disk is full, and give the same command again to go on",
               error.what());
  }
}

// Sums of a count of each array.
std::vector<int64_t> runningSums(const std::vector<PackedArray>& arrays,
                                 int64_t (ZarrArray::*count)() const) {
  std::vector<int64_t> firsts{0};
  for (const PackedArray& packed : arrays)
    firsts.push_back(firsts.back() + (packed.array.*count)());
  return firsts;
}

// The index of a chunk within an array, from its shard's and its number in the shard.
std::vector<int64_t> chunkIndexIn(const ZarrArray& array, std::span<const int64_t> shard,
                                  int64_t number) {
  std::vector<int64_t> index(array.axes());
  for (size_t a = array.axes(); a-- > 0;) {
    const int64_t along = array.files[a] / array.chunks[a];
    index[a] = shard[a] * along + number % along;
    number /= along;
  }
  return index;
}

bool isInside(const ZarrArray& array, std::span<const int64_t> index) {
  for (size_t a = 0; a < array.axes(); ++a)
    if (index[a] * array.chunks[a] >= array.shape[a]) return false;
  return true;
}

}  // namespace

ZarrPackFolder::ZarrPackFolder(const fs::path& output, std::vector<PackedArray> arrays,
                               const std::string& source_identity, const std::string& parameters,
                               BegunByOthers others)
    : output_(withoutSlash(output)),
      folder_(suffixedName(output_, ".partial")),
      store_(folder_ / "store"),
      arrays_(std::move(arrays)),
      first_chunks_(runningSums(arrays_, &ZarrArray::chunkCount)),
      first_files_(runningSums(arrays_, &ZarrArray::fileCount)),
      chunks_(static_cast<size_t>(first_chunks_.back())),
      done_(chunks_.size(), 0) {
  if (hasShards()) {
    offsets_.resize(chunks_.size());
    ends_.resize(static_cast<size_t>(first_files_.back()));
  }
  // The order matters: only who holds the lock may look at what is there.
  lock();
  checkParameters(source_identity, parameters, others);
  for (const PackedArray& packed : arrays_) makeFolders(store_ / packed.folder);
  journal_.emplace(folder_ / "journal");
}

uint64_t ZarrPackFolder::tableBytes(const ZarrArray& array) {
  const uint64_t chunk = sizeof(StoredChunk) + 1 + (array.shards ? sizeof(uint64_t) : 0);
  return static_cast<uint64_t>(array.chunkCount()) * chunk;
}

size_t ZarrPackFolder::arrayOf(int64_t chunk) const {
  const auto after = std::upper_bound(first_chunks_.begin(), first_chunks_.end(), chunk);
  return static_cast<size_t>(after - first_chunks_.begin()) - 1;
}

fs::path ZarrPackFolder::chunkPath(int64_t chunk) const {
  const size_t i = arrayOf(chunk);
  const ZarrArray& array = arrays_[i].array;
  return store_ / arrays_[i].folder / array.fileName(array.placeOf(chunk - first_chunks_[i]).file);
}

size_t ZarrPackFolder::shardOf(int64_t chunk) const {
  const size_t i = arrayOf(chunk);
  return static_cast<size_t>(first_files_[i] +
                             arrays_[i].array.placeOf(chunk - first_chunks_[i]).file);
}

int64_t ZarrPackFolder::chunkFiles() const {
  if (hasShards())
    return std::count_if(ends_.begin(), ends_.end(), [](uint64_t end) { return end > 0; });
  return std::count_if(chunks_.begin(), chunks_.end(),
                       [](const StoredChunk& chunk) { return chunk.bytes > 0; });
}

void ZarrPackFolder::append(int64_t chunk, std::span<const std::byte> stored, uint64_t offset) {
  const fs::path path = chunkPath(chunk);
  const auto openShard = [&] {
    return Descriptor(open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666));
  };
  Descriptor file = openShard();
  // Folders of chunks are made when the first chunk needs them: most chunks find theirs.
  if (!file && errno == ENOENT) {
    makeFolders(path.parent_path());
    file = openShard();
  }
  if (!file || lseek(file.get(), static_cast<off_t>(offset), SEEK_SET) < 0)
    failErrno(fmt::format("{}: cannot be written", path.string()), errno);
  writePart(file.get(), stored, path);
  const uint32_t crc = crc32c(stored);
  writePart(file.get(), std::as_bytes(std::span(&crc, 1)), path);
}

void ZarrPackFolder::writeIndices(size_t array_number) {
  const ZarrArray& array = arrays_[array_number].array;
  const auto count = static_cast<size_t>(array.chunksAFile());
  for (int64_t shard = 0; shard < array.fileCount(); ++shard) {
    const uint64_t end = ends_[static_cast<size_t>(first_files_[array_number] + shard)];
    if (end == 0) continue;  // all fill value
    const std::vector<int64_t> at = array.fileIndex(shard);
    // Chunks that are all fill value are marked by two numbers of all ones (Zarr v3, sharding
    // codec).
    std::vector<uint64_t> index(2 * count, UINT64_MAX);
    for (size_t i = 0; i < count; ++i) {
      const std::vector<int64_t> inside = chunkIndexIn(array, at, static_cast<int64_t>(i));
      if (!isInside(array, inside)) continue;
      const auto chunk =
          static_cast<size_t>(first_chunks_[array_number] + array.chunkNumber(inside));
      if (chunks_[chunk].bytes == 0) continue;
      index[2 * i] = offsets_[chunk];
      index[2 * i + 1] = chunks_[chunk].bytes;
    }
    const std::string path =
        (store_ / arrays_[array_number].folder / array.fileName(shard)).string();
    const Descriptor file = openedFile(path, O_WRONLY);
    // Removes bytes that an interrupted run left behind the last chunk.
    if (ftruncate(file.get(), static_cast<off_t>(end)) != 0 ||
        lseek(file.get(), static_cast<off_t>(end), SEEK_SET) < 0)
      failErrno(fmt::format("{}: cannot be written", path), errno);
    const std::span bytes = std::as_bytes(std::span(index));
    const uint32_t crc = crc32c(bytes);
    writePart(file.get(), bytes, path);
    writePart(file.get(), std::as_bytes(std::span(&crc, 1)), path);
  }
}

void ZarrPackFolder::write(int64_t chunk, std::span<const std::byte> stored, int thread) {
  resumably([&] { store(chunk, stored, thread); });
}

void ZarrPackFolder::store(int64_t chunk, std::span<const std::byte> stored, int thread) {
  PackRecord record{.chunk = static_cast<uint64_t>(chunk), .bytes = stored.size()};
  if (!stored.empty() && hasShards()) {
    record.checksum = zarrChecksum(stored);
    record.bytes += kShardCrcBytes;
    {
      const MutexLock lock(mutex_);
      // The place is taken under the lock, and the bytes are written without it.
      record.offset = std::exchange(ends_[shardOf(chunk)], ends_[shardOf(chunk)] + record.bytes);
    }
    append(chunk, stored, record.offset);
  } else if (!stored.empty()) {
    record.checksum = zarrChecksum(stored);
    const fs::path temporary = folder_ / fmt::format("chunk-{}.tmp", thread);
    const fs::path path = chunkPath(chunk);
    {
      const Descriptor file = openedFile(temporary, O_WRONLY | O_CREAT | O_TRUNC);
      writePart(file.get(), stored, path);
    }
    if (rename(temporary.c_str(), path.c_str()) != 0) {
      makeFolders(path.parent_path());
      renamePath(temporary, path);
    }
  }
  const MutexLock lock(mutex_);
  // After the chunk is in its place: the journal never names one that was not written.
  journal_->add(record);
  chunks_[record.chunk] = {record.bytes, record.checksum};
  if (hasShards()) offsets_[record.chunk] = record.offset;
  done_[record.chunk] = 1;
}

fs::path ZarrPackFolder::complete(const std::string& group_text, const std::string& image_text,
                                  const std::vector<ZarrArrayTexts>& array_texts) {
  resumably([&] { describe(group_text, image_text, array_texts); });
  return store_;
}

void ZarrPackFolder::describe(const std::string& group_text, const std::string& image_text,
                              const std::vector<ZarrArrayTexts>& array_texts) {
  const auto write = [](const fs::path& path, const std::string& text) {
    AtomicFile file(path);
    file.write(text);
    file.commit();
  };
  // Zarr 3 has one file of metadata for each group and array.
  if (!hasShards()) write(store_ / ".zgroup", group_text);
  write(store_ / (hasShards() ? "zarr.json" : ".zattrs"), image_text);
  const char* const group_name = hasShards() ? "zarr.json" : ".zgroup";
  for (size_t i = 0; i < arrays_.size(); ++i) {
    const fs::path name = arrays_[i].folder, folder = store_ / name;
    if (name.has_parent_path()) write(store_ / name.parent_path() / group_name, group_text);
    if (hasShards()) {
      writeIndices(i);
      write(folder / "zarr.json", array_texts[i].header);
      continue;
    }
    write(folder / ".zarray", array_texts[i].header);
    if (!array_texts[i].attributes.empty()) write(folder / ".zattrs", array_texts[i].attributes);
    const auto first = static_cast<size_t>(first_chunks_[i]);
    const auto end = static_cast<size_t>(first_chunks_[i + 1]);
    writeZarrChecksums(folder, array_texts[i].header,
                       std::span(chunks_).subspan(first, end - first));
  }
}

void ZarrPackFolder::discard() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void ZarrPackFolder::finish(const FinishOptions& options) {
  resumably([&] { putInPlace(options); });
}

void ZarrPackFolder::putInPlace(const FinishOptions& options) {
  // All bytes are on the disk before the store has its name.
  if (options.sync) syncFolder(folder_, true);
  requireFreeName(output_, options.replace);
  if (fs::exists(output_)) {
    // In one step if the file system can; the old store then lies in the new one's place.
    if (renameat2(AT_FDCWD, store_.c_str(), AT_FDCWD, output_.c_str(), RENAME_EXCHANGE) != 0) {
      renamePath(output_, folder_ / "replaced");
      renamePath(store_, output_);
    }
  } else {
    renamePath(store_, output_);
  }
  const fs::path parent = fs::absolute(output_).parent_path();
  if (options.sync) syncFolder(parent, false);
  std::error_code ignored;  // the store is whole; the rest is litter
  fs::remove_all(folder_, ignored);
}

}  // namespace sluice
