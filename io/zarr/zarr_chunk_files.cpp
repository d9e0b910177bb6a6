#include "io/zarr/zarr_chunk_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <utility>

#include "io/files/byte_store.h"
#include "io/files/file.h"
#include "io/zarr/zarr_codec.h"
#include "src/base/error.h"
#include "src/base/files/descriptor.h"

namespace sluice {
namespace {

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

}  // namespace

ZarrChunkFiles::ZarrChunkFiles(std::filesystem::path folder, ZarrArray array,
                               std::string_view array_text)
    : folder_(std::move(folder)), array_(std::move(array)) {
  clock_gettime(CLOCK_REALTIME, &opened_at_);
  checksums_ = readZarrChecksums(folder_, array_text, array_.chunkCount());
  if (checksums_) read_bytes_ += std::filesystem::file_size(folder_ / kZarrChecksumsName);
}

const StoredChunk& ZarrChunkFiles::stored(int64_t chunk) const {
  return (*checksums_)[static_cast<size_t>(chunk)];
}

std::string ZarrChunkFiles::path(int64_t chunk) const {
  return folder_.string() + "/" + array_.chunkName(chunk);
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
  return std::binary_search(all.begin(), all.end(), chunk);
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
  listFolder(folder_, index, found);
  std::sort(found.begin(), found.end());
  return found;
}

uint64_t ZarrChunkFiles::statusChecksum(int64_t most) const {
  const int64_t chunks = array_.chunkCount(), sampled = std::min(chunks, most);
  std::string all;
  for (int64_t i = 0; i < sampled; ++i) {
    // Computed without a product that could overflow.
    const int64_t chunk = chunks / sampled * i + chunks % sampled * i / sampled;
    struct stat status = {};
    const bool is_there = stat(path(chunk).c_str(), &status) == 0;
    all += is_there ? describeStatus(status) : "none";
    all += '\n';
  }
  return zarrChecksum(std::as_bytes(std::span(all)));
}

// With '/' a folder is a digit of the number; `index` has the digits of the folders above.
void ZarrChunkFiles::listFolder(const std::filesystem::path& folder, std::vector<int64_t>& index,
                                std::vector<int64_t>& found) const {
  const auto take = [&](std::string_view text) {
    const auto value = indexIn(text, array_.chunksAlong(index.size()));
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
        found.push_back(array_.chunkNumber(index));
      else if (entries->is_directory(status))
        listFolder(entries->path(), index, found);
      status.clear();
    } else {
      std::string_view rest = name;
      bool is_chunk = true;
      while (is_chunk && index.size() < array_.axes()) {
        const bool last = index.size() + 1 == array_.axes();
        const size_t end = last ? rest.size() : std::min(rest.find('.'), rest.size());
        is_chunk = take(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
      }
      if (is_chunk) found.push_back(array_.chunkNumber(index));
    }
    index.resize(depth);
  }
  if (status) fail("{}: cannot be listed: {}", folder.string(), status.message());
}

void ZarrChunkFiles::read(int64_t chunk,
                          const std::function<std::span<std::byte>(uint64_t bytes)>& room) {
  const std::string file = path(chunk);
  const Descriptor descriptor = openChunk(file);
  if (!descriptor)
    failErrno(fmt::format("{}: expected a chunk, which was there when {}, found none", file,
                          checksums_ ? "the store was packed" : "the volume was opened"),
              errno);
  struct stat status = {};
  if (fstat(descriptor.get(), &status) != 0) failErrno(file, errno);
  if (!S_ISREG(status.st_mode)) fail("{}: expected a chunk, found no regular file", file);
  const auto bytes = static_cast<uint64_t>(status.st_size);
  if (checksums_ && bytes != stored(chunk).bytes)
    fail("{}: expected {} bytes, as packed, found {}", file, stored(chunk).bytes, bytes);
  checkStoredSize(array_.codec, bytes, array_.chunkBytes(), file);
  const std::span<std::byte> out = room(bytes);
  const iovec part{out.data(), out.size()};
  const uint64_t got = readParts(file, descriptor.get(), 0, std::span(&part, 1));
  read_bytes_ += got;
  if (got < bytes) fail("{}: expected {} bytes, found {}; it was cut short", file, bytes, got);
  if (checksums_) {
    const uint64_t found = zarrChecksum(out);
    if (found != stored(chunk).checksum)
      fail("{}: expected the checksum {:016x}, as packed, found {:016x}; the chunk is damaged",
           file, stored(chunk).checksum, found);
    return;
  }
  // A time in the future is a clock that is wrong, not a change.
  timespec now = {};
  clock_gettime(CLOCK_REALTIME, &now);
  if (isBefore(opened_at_, status.st_mtim) && isBefore(status.st_mtim, now))
    fail("{}: changed while the volume was open; open it again", file);
}

}  // namespace sluice
