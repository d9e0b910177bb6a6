#include "io/zarr/reading/zarr_chunk_files.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include "io/files/swap_bytes.h"
#include "io/zarr/n5/n5_block.h"
#include "io/zarr/reading/crc32c.h"
#include "io/zarr/reading/zarr_codec.h"
#include "src/base/error.h"
#include "src/base/files/number_text.h"
#include "src/base/values/number_set.h"

namespace sluice {
namespace {

// A packed store that is not as it was packed ends with this advice.
constexpr const char* kMendStore = "copy the store again or pack it again";

constexpr uint64_t kCrcBytes = sizeof(uint32_t);
constexpr uint64_t kIndexCacheBytes = 4 << 20;  // until setBudget()
constexpr size_t kMostMissing = 1 << 16;        // a few megabytes
constexpr uint64_t kSmallChunkBytes = 4 << 20;

// The most that codecs make of a chunk: what they cannot compress they store with a few headers.
constexpr uint64_t mostStoredBytes(uint64_t chunk_bytes) {
  return chunk_bytes + chunk_bytes / 128 + 256;
}

// A number as it stands in a chunk's name: digits alone, no leading zero, below `end`.
std::optional<int64_t> indexIn(std::string_view text, int64_t end) {
  const auto value = numberIn<int64_t>(text);
  // A name such as 007 is no chunk's.
  const bool is_index = value && *value >= 0 && *value < end && std::to_string(*value) == text;
  return is_index ? value : std::nullopt;
}

// Throws Error, naming the file, unless the CRC32C at the end of `stored` is that of the rest.
void requireCrc(std::span<const std::byte> stored, const std::string& path, const char* what) {
  const std::span<const std::byte> content = stored.first(stored.size() - kCrcBytes);
  uint32_t expected = 0;
  std::memcpy(&expected, stored.data() + content.size(), kCrcBytes);
  const uint32_t found = crc32c(content);
  if (found != expected)
    fail("{}: expected the CRC32C {:08x}, as stored, found {:08x}; {} is damaged", path, expected,
         found, what);
}

}  // namespace

ZarrChunkFiles::ZarrChunkFiles(StorePlace folder, ZarrArray array, std::string_view array_text)
    : folder_(std::move(folder)), array_(std::move(array)) {
  if (!array_.shards) checksums_ = readZarrChecksums(folder_, array_text, array_.chunkCount());
  if (checksums_) read_bytes_ += zarrChecksumsBytes(*checksums_);
  if (array_.shards)
    indices_ = std::make_unique<ZarrShardIndices>(
        array_, kIndexCacheBytes,
        [this](int64_t file, std::span<std::byte> index) { readIndex(file, index); });
}

const StoredChunk& ZarrChunkFiles::stored(int64_t chunk) const {
  return (*checksums_)[static_cast<size_t>(chunk)];
}

uint64_t ZarrChunkFiles::digestOfChecksums() const {
  return zarrChecksum(std::as_bytes(std::span(*checksums_)));
}

std::string ZarrChunkFiles::stamp() const {
  return fmt::format("{:016x}", checksums_ ? digestOfChecksums() : stampChecksum(kSampledChunks));
}

std::string ZarrChunkFiles::path(int64_t chunk) const {
  return folder_.at(array_.fileName(array_.placeOf(chunk).file)).name();
}

const std::vector<int64_t>& ZarrChunkFiles::existing() {
  std::call_once(listed_, [this] { list(); });
  return existing_;
}

bool ZarrChunkFiles::exists(int64_t chunk) {
  if (checksums_) {
    // The checksums tell which chunks there are, without a look at the folder.
    if (stored(chunk).bytes > 0) return true;
    if (folder_.store->canList() && folder_.has(array_.fileName(array_.placeOf(chunk).file)))
      fail("{}: expected no such chunk, as packed, found one; {}", path(chunk), kMendStore);
    return false;
  }
  const ZarrArray::Place place = array_.placeOf(chunk);
  if (areKnown()) {
    const std::vector<int64_t>& all = existing();
    if (!std::binary_search(all.begin(), all.end(), place.file)) return false;
    // On the web each question is a request.
  } else if (isRememberedMissing(place.file)) {
    return false;
  }
  return !indices_ || indices_->find(place).has_value();
}

void ZarrChunkFiles::list() {
  if (checksums_) {
    for (size_t i = 0; i < checksums_->size(); ++i)
      if ((*checksums_)[i].bytes > 0) existing_.push_back(static_cast<int64_t>(i));
  } else {
    existing_ = onDisk();
  }
}

std::vector<int64_t> ZarrChunkFiles::onDisk() const {
  std::vector<int64_t> index, found;
  const bool is_below = !array_.prefix.empty() && array_.separator == '/';
  listFolder(is_below ? folder_.at(array_.prefix) : folder_, index, found);
  if (array_.fileCount() > NumberSet::kMostNumbers) {
    std::sort(found.begin(), found.end());
    return found;
  }
  NumberSet files(array_.fileCount());
  for (const int64_t file : found) files.add(file);
  return files.numbers();
}

uint64_t ZarrChunkFiles::stampChecksum(int64_t most) const {
  const int64_t files = array_.fileCount(), sampled = std::min(files, most);
  std::string all;
  for (int64_t i = 0; i < sampled; ++i) {
    // Computed without a product that could overflow.
    const int64_t file = files / sampled * i + files % sampled * i / sampled;
    all += folder_.store->stampOf(folder_.at(array_.fileName(file)).key) + '\n';
  }
  return zarrChecksum(std::as_bytes(std::span(all)));
}

// With '/' a folder is a digit of the number; `index` has the digits of the folders above.
void ZarrChunkFiles::listFolder(const StorePlace& folder, std::vector<int64_t>& index,
                                std::vector<int64_t>& found) const {
  const auto take = [&](std::string_view text) {
    const size_t axis = array_.is_n5 ? array_.axes() - 1 - index.size() : index.size();
    const auto value = indexIn(text, array_.filesAlong(axis));
    if (value) index.push_back(*value);
    return value.has_value();
  };
  folder.store->list(folder.key, [&](const ChunkStore::Entry& entry) {
    const size_t depth = index.size();
    if (array_.separator == '/') {
      if (!take(entry.name)) return;
      if (index.size() == array_.axes())
        found.push_back(array_.fileNumber(
            array_.is_n5 ? std::vector<int64_t>(index.rbegin(), index.rend()) : index));
      else if (entry.is_folder)
        listFolder(folder.at(entry.name), index, found);
    } else {
      std::string_view rest = entry.name;
      const std::string before = array_.prefix.empty() ? "" : array_.prefix + array_.separator;
      bool is_chunk = rest.starts_with(before);
      if (is_chunk) rest.remove_prefix(before.size());
      while (is_chunk && index.size() < array_.axes()) {
        const bool last = index.size() + 1 == array_.axes();
        const size_t end = last ? rest.size() : std::min(rest.find('.'), rest.size());
        is_chunk = take(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
      }
      if (is_chunk) found.push_back(array_.fileNumber(index));
    }
    index.resize(depth);
  });
}

void ZarrChunkFiles::rememberMissing(int64_t file) {
  const MutexLock lock(mutex_);
  if (missing_.size() < kMostMissing) missing_.insert(file);
}

bool ZarrChunkFiles::isRememberedMissing(int64_t file) {
  const MutexLock lock(mutex_);
  return missing_.contains(file);
}

bool ZarrChunkFiles::readFile(int64_t file, const PieceBytes& wanted, const Room& room) {
  const StorePlace place = folder_.at(array_.fileName(file));
  uint64_t bytes = 0;
  const bool is_there = place.store->read(place.key, wanted, [&](const PieceInfo& piece) {
    // Those with checksums are compared with these.
    if (!checksums_ && piece.has_changed)
      fail("{}: changed while the volume was open; open it again", place.name());
    const std::span<std::byte> out = room(piece);
    bytes = out.size();
    return out;
  });
  read_bytes_ += bytes;
  if (!is_there && areKnown())
    fail("{}: expected a chunk, which was there when {}, found none", place.name(),
         checksums_ ? "the store was packed" : "the volume was opened");
  return is_there;
}

PieceBytes ZarrChunkFiles::indexPiece() const {
  const auto from = array_.shards->is_first ? PieceBytes::From::kStart : PieceBytes::From::kEnd;
  return {from, 0, array_.shardIndexBytes()};
}

StoredReads ZarrChunkFiles::storedReads(std::span<const int64_t> chunks) {
  StoredReads reads;
  const auto count = [&](const std::string& key, const PieceBytes& piece, uint64_t most_bytes) {
    const std::optional<uint64_t> kept = folder_.store->keptCopy(key, piece);
    if (kept)
      ++reads.kept;
    else
      reads.most_bytes += most_bytes;
  };
  const uint64_t behind = array_.has_crc ? kCrcBytes : 0;
  const bool is_plain = array_.codec == ZarrCodec::kNone && !array_.is_n5;
  const uint64_t most = is_plain ? array_.chunkBytes() : mostStoredBytes(array_.chunkBytes());
  // The shards that were met, each with the copy of its index, if one is kept.
  std::map<int64_t, std::vector<std::byte>> indices;
  for (const int64_t chunk : chunks) {
    if (checksums_ && stored(chunk).bytes == 0) continue;
    const ZarrArray::Place place = array_.placeOf(chunk);
    if (!checksums_ && areKnown() &&
        !std::binary_search(existing().begin(), existing().end(), place.file))
      continue;
    const std::string key = folder_.at(array_.fileName(place.file)).key;
    PieceBytes piece;
    uint64_t bytes = checksums_ ? stored(chunk).bytes : most + behind;
    bool has_place = !indices_;
    if (indices_) {
      const auto [index, is_new] = indices.try_emplace(place.file);
      if (is_new) {
        ++reads.indices;
        index->second.resize(array_.shardIndexBytes());
        count(key, indexPiece(), index->second.size());
        if (!folder_.store->keptCopy(key, indexPiece(), index->second)) index->second.clear();
      }
      if (!index->second.empty()) {
        const auto at = ZarrShardIndices::entryOf(array_, index->second, place.chunk);
        if (!at) continue;
        piece = {PieceBytes::From::kStart, at->offset, at->bytes};
        bytes = at->bytes;
        has_place = true;
      }
    }
    ++reads.chunks;
    if (has_place)
      count(key, piece, bytes);
    else
      reads.most_bytes += bytes;
  }
  return reads;
}

void ZarrChunkFiles::readIndex(int64_t number, std::span<std::byte> index) {
  const std::string path = folder_.at(array_.fileName(number)).name();
  const bool is_there = readFile(number, indexPiece(), [&](const PieceInfo& piece) {
    if (piece.bytes < index.size())
      fail("{}: expected a shard with an index of {} bytes, found {}", path, index.size(),
           piece.bytes);
    return index;
  });
  if (!is_there) {
    // A shard without a file has no chunks.
    rememberMissing(number);
    return ZarrShardIndices::setMissing(index);
  }
  if (array_.shards->has_crc) requireCrc(index, path, "the index of the shard");
}

std::optional<uint64_t> ZarrChunkFiles::read(
    int64_t chunk, const std::function<std::span<std::byte>(uint64_t bytes)>& room) {
  const ZarrArray::Place place = array_.placeOf(chunk);
  const std::string path = this->path(chunk);
  PieceBytes wanted;
  if (indices_) {
    const std::optional<ZarrChunkPlace> part = indices_->find(place);
    if (!part) fail("{}: expected a chunk, which was there before, found none", path);
    wanted = {PieceBytes::From::kStart, part->offset, part->bytes};
  }
  const uint64_t behind = array_.has_crc ? kCrcBytes : 0;
  std::span<std::byte> out;
  const bool is_there = readFile(place.file, wanted, [&](const PieceInfo& piece) {
    if (checksums_ && piece.bytes != stored(chunk).bytes)
      fail("{}: expected {} bytes, as packed, found {}; the chunk is damaged, {}", path,
           stored(chunk).bytes, piece.bytes, kMendStore);
    if (!indices_) wanted.bytes = piece.bytes;
    // The index comes from the file, so its places are checked before room is made.
    if (wanted.offset > piece.bytes || wanted.bytes > piece.bytes - wanted.offset)
      fail(
          "{}: expected chunks within its {} bytes, found one of {} at {}; the shard was cut short",
          path, piece.bytes, wanted.bytes, wanted.offset);
    if (wanted.bytes < behind)
      fail("{}: expected a chunk with a checksum, found {} bytes", path, wanted.bytes);
    if (array_.is_n5)
      checkN5Size(wanted.bytes, array_.chunkBytes(), path);
    else
      // Before room is made: a damaged size must not take memory.
      checkStoredSize(array_.codec, wanted.bytes - behind, array_.chunkBytes(), path);
    out = room(wanted.bytes);
    return out;
  });
  if (!is_there) {
    if (indices_) fail("{}: expected a shard, which was there before, found none", path);
    rememberMissing(place.file);
    return std::nullopt;
  }
  if (checksums_) {
    const uint64_t found = zarrChecksum(out);
    if (found != stored(chunk).checksum)
      fail("{}: expected the checksum {:016x}, as packed, found {:016x}; the chunk is damaged, {}",
           path, stored(chunk).checksum, found, kMendStore);
  }
  if (array_.has_crc) requireCrc(out, path, "a chunk");
  return wanted.bytes - behind;
}

std::shared_ptr<CountedBytes> ZarrChunkFiles::load(int64_t chunk, ChunkMemory& memory) {
  std::shared_ptr<CountedBytes> decoded;
  std::unique_ptr<CountedBytes> stored;
  const std::optional<uint64_t> stored_bytes = read(chunk, [&](uint64_t bytes) {
    if (array_.codec == ZarrCodec::kNone && !array_.is_n5) {
      decoded = std::make_shared<CountedBytes>(bytes, memory);
      return decoded->span();
    }
    // For chunks of up to kSmallChunkBytes, the buffer has the size of a decoded chunk, so that it
    // can be reused for any of them.
    stored = std::make_unique<CountedBytes>(
        std::max(bytes, std::min(array_.chunkBytes(), kSmallChunkBytes)), memory);
    return stored->span().first(bytes);
  });
  if (!stored_bytes) return nullptr;
  if (stored) {
    const auto file = std::as_const(*stored).span().first(*stored_bytes);
    const std::string path = this->path(chunk);
    const N5Block block = array_.is_n5 ? parseN5Block(array_, chunk, file, path) : N5Block{file};
    const uint64_t bytes = array_.is_n5 ? block.bytes : array_.chunkBytes();
    // Before the decoded chunk has room: a few bytes cannot hold a large chunk.
    checkStored(array_.codec, block.stored, bytes, path);
    decoded = std::make_shared<CountedBytes>(array_.chunkBytes(), memory);
    decodeChunk(array_.codec, block.stored, decoded->span().first(bytes), path);
    if (array_.is_n5) spreadN5Block(array_, block, decoded->span());
  }
  if (array_.byte_order != std::endian::native)
    swapBytes(decoded->span().first(array_.chunkBytes()), bytesPerVoxel(array_.type));
  return decoded;
}

}  // namespace sluice
