#include "io/zarr/zarr_chunk_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include "io/files/byte_store.h"
#include "io/files/file.h"
#include "io/zarr/crc32c.h"
#include "io/zarr/zarr_codec.h"
#include "src/base/error.h"
#include "src/base/files/descriptor.h"

namespace sluice {
namespace {

constexpr uint64_t kCrcBytes = sizeof(uint32_t);
constexpr uint64_t kIndexCacheBytes = 4 << 20;  // until setBudget()

Descriptor openChunk(const std::string& path) {
  return Descriptor(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
}

bool isBefore(const timespec& a, const timespec& b) {
  return a.tv_sec < b.tv_sec || (a.tv_sec == b.tv_sec && a.tv_nsec < b.tv_nsec);
}

// A number as it stands in a chunk's name: digits alone, no leading zero, below `end`.
std::optional<int64_t> indexIn(std::string_view text, int64_t end) {
  int64_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size() || value < 0 || value >= end ||
      std::to_string(value) != text)
    return std::nullopt;
  return value;
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

struct ZarrChunkFiles::OpenFile {
  std::string path;
  Descriptor descriptor;
  uint64_t bytes = 0;
};

ZarrChunkFiles::ZarrChunkFiles(std::filesystem::path folder, ZarrArray array,
                               std::string_view array_text)
    : folder_(std::move(folder)), array_(std::move(array)) {
  clock_gettime(CLOCK_REALTIME, &opened_at_);
  if (!array_.shards) checksums_ = readZarrChecksums(folder_, array_text, array_.chunkCount());
  if (checksums_) read_bytes_ += std::filesystem::file_size(folder_ / kZarrChecksumsName);
  if (array_.shards)
    indices_ = std::make_unique<ZarrShardIndices>(
        array_, kIndexCacheBytes,
        [this](int64_t file, std::span<std::byte> index) { readIndex(file, index); });
}

const StoredChunk& ZarrChunkFiles::stored(int64_t chunk) const {
  return (*checksums_)[static_cast<size_t>(chunk)];
}

std::string ZarrChunkFiles::path(int64_t chunk) const {
  return folder_.string() + "/" + array_.fileName(array_.placeOf(chunk).file);
}

const std::vector<int64_t>& ZarrChunkFiles::existing() {
  std::call_once(listed_, [this] { list(); });
  return existing_;
}

bool ZarrChunkFiles::exists(int64_t chunk) {
  if (checksums_) {
    if (stored(chunk).bytes > 0) return true;
    if (access(path(chunk).c_str(), F_OK) == 0)
      fail("{}: expected no such chunk, as packed, found one", path(chunk));
    return false;
  }
  const std::vector<int64_t>& all = existing();
  const ZarrArray::Place place = array_.placeOf(chunk);
  if (!std::binary_search(all.begin(), all.end(), place.file)) return false;
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
  const std::filesystem::path top = is_below ? folder_ / array_.prefix : folder_;
  std::error_code status;
  if (is_below && !std::filesystem::exists(top, status) && !status) return found;
  listFolder(top, index, found);
  std::sort(found.begin(), found.end());
  return found;
}

uint64_t ZarrChunkFiles::statusChecksum(int64_t most) const {
  const int64_t files = array_.fileCount(), sampled = std::min(files, most);
  std::string all;
  for (int64_t i = 0; i < sampled; ++i) {
    // Computed without a product that could overflow.
    const int64_t file = files / sampled * i + files % sampled * i / sampled;
    struct stat status = {};
    const bool is_there = stat((folder_ / array_.fileName(file)).c_str(), &status) == 0;
    all += is_there ? describeStatus(status) : "none";
    all += '\n';
  }
  return zarrChecksum(std::as_bytes(std::span(all)));
}

// With '/' a folder is a digit of the number; `index` has the digits of the folders above.
void ZarrChunkFiles::listFolder(const std::filesystem::path& folder, std::vector<int64_t>& index,
                                std::vector<int64_t>& found) const {
  const auto take = [&](std::string_view text) {
    const auto value = indexIn(text, array_.filesAlong(index.size()));
    if (value) index.push_back(*value);
    return value.has_value();
  };
  std::error_code status;
  std::filesystem::directory_iterator entries(folder, status);
  for (; !status && entries != std::filesystem::directory_iterator(); entries.increment(status)) {
    const std::string name = entries->path().filename().string();
    const size_t depth = index.size();
    if (array_.separator == '/') {
      if (!take(name)) continue;
      if (index.size() == array_.axes())
        found.push_back(array_.fileNumber(index));
      else if (entries->is_directory(status))
        listFolder(entries->path(), index, found);
      status.clear();
    } else {
      std::string_view rest = name;
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
  }
  if (status) fail("{}: cannot be listed: {}", folder.string(), status.message());
}

ZarrChunkFiles::OpenFile ZarrChunkFiles::openFile(int64_t file) const {
  const std::string path = folder_.string() + "/" + array_.fileName(file);
  OpenFile opened{path, openChunk(path)};
  if (!opened.descriptor)
    failErrno(fmt::format("{}: expected a chunk, which was there when {}, found none", opened.path,
                          checksums_ ? "the store was packed" : "the volume was opened"),
              errno);
  struct stat status = {};
  if (fstat(opened.descriptor.get(), &status) != 0) failErrno(opened.path, errno);
  if (!S_ISREG(status.st_mode)) fail("{}: expected a chunk, found no regular file", opened.path);
  opened.bytes = static_cast<uint64_t>(status.st_size);
  if (checksums_) return opened;
  // A time in the future is a clock that is wrong, not a change.
  timespec now = {};
  clock_gettime(CLOCK_REALTIME, &now);
  if (isBefore(opened_at_, status.st_mtim) && isBefore(status.st_mtim, now))
    fail("{}: changed while the volume was open; open it again", opened.path);
  return opened;
}

void ZarrChunkFiles::readAll(const OpenFile& file, uint64_t offset, std::span<std::byte> out) {
  const iovec part{out.data(), out.size()};
  const uint64_t got = readParts(file.path, file.descriptor.get(), offset, std::span(&part, 1));
  read_bytes_ += got;
  if (got < out.size())
    fail("{}: expected {} bytes, found {}; it was cut short", file.path, offset + out.size(),
         offset + got);
}

void ZarrChunkFiles::readIndex(int64_t number, std::span<std::byte> index) {
  const OpenFile file = openFile(number);
  if (file.bytes < index.size())
    fail("{}: expected a shard with an index of {} bytes, found {}", file.path, index.size(),
         file.bytes);
  readAll(file, array_.shards->is_first ? 0 : file.bytes - index.size(), index);
  if (array_.shards->has_crc) requireCrc(index, file.path, "the index of the shard");
}

ZarrChunkPlace ZarrChunkFiles::placeIn(const OpenFile& file, int64_t chunk) {
  if (checksums_ && file.bytes != stored(chunk).bytes)
    fail("{}: expected {} bytes, as packed, found {}", file.path, stored(chunk).bytes, file.bytes);
  if (!indices_) return {0, file.bytes};
  const std::optional<ZarrChunkPlace> place = indices_->find(array_.placeOf(chunk));
  if (!place) fail("{}: expected a chunk, which was there before, found none", file.path);
  if (place->offset > file.bytes || place->bytes > file.bytes - place->offset)
    fail("{}: expected chunks within its {} bytes, found one of {} at {}; the shard was cut short",
         file.path, file.bytes, place->bytes, place->offset);
  return *place;
}

uint64_t ZarrChunkFiles::read(int64_t chunk,
                              const std::function<std::span<std::byte>(uint64_t bytes)>& room) {
  const OpenFile file = openFile(array_.placeOf(chunk).file);
  const ZarrChunkPlace place = placeIn(file, chunk);
  const uint64_t behind = array_.has_crc ? kCrcBytes : 0;
  if (place.bytes < behind)
    fail("{}: expected a chunk with a checksum, found {} bytes", file.path, place.bytes);
  checkStoredSize(array_.codec, place.bytes - behind, array_.chunkBytes(), file.path);
  const std::span<std::byte> out = room(place.bytes);
  readAll(file, place.offset, out);
  if (checksums_) {
    const uint64_t found = zarrChecksum(out);
    if (found != stored(chunk).checksum)
      fail("{}: expected the checksum {:016x}, as packed, found {:016x}; the chunk is damaged",
           file.path, stored(chunk).checksum, found);
  }
  if (array_.has_crc) requireCrc(out, file.path, "a chunk");
  return place.bytes - behind;
}

}  // namespace sluice
