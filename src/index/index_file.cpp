#include "src/index/index_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "src/base/error.h"
#include "src/base/files/atomic_file.h"
#include "src/base/files/descriptor.h"
#include "src/base/memory/large_pages.h"
#include "src/base/sources/synth_name.h"
#include "src/base/values/text_parts.h"

namespace sluice {
namespace {

// A file is this header, the identity, the key's name, the blob, and nothing after it. It is in
// this machine's byte order: another machine finds the magic reversed and builds its own.
struct Header {
  uint64_t magic = 0x31584449'4c554953;  // "SIULIDX1" in little-endian memory
  uint32_t container_version = 1;
  uint32_t key_version = 0;
  uint32_t identity_bytes = 0;
  uint32_t what_bytes = 0;
  uint64_t blob_bytes = 0;
  uint64_t blob_checksum = 0;    // XXH3 of the blob
  uint64_t header_checksum = 0;  // XXH3 of the header with 0 here, then of identity and what
};
static_assert(sizeof(Header) == 48, "no padding, whose bytes would be unchecked");

uint64_t checksumOf(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::string headerAndKey(Header header, const std::string& key_text) {
  std::string text(sizeof header, '\0');
  header.header_checksum = 0;
  std::memcpy(text.data(), &header, sizeof header);
  text += key_text;
  header.header_checksum = checksumOf(std::as_bytes(std::span(text)));
  std::memcpy(text.data(), &header, sizeof header);
  return text;
}

// `what` as a file name; a hash tells apart names that had to be changed.
std::string fileName(const std::string& what) {
  std::string name;
  // Names of files are limited, to 255 bytes on most systems.
  bool changed = what.empty() || what.size() > 100;
  for (const char c : what.substr(0, 100)) {
    const bool safe = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' ||
                      (c == '.' && !name.empty());
    name += safe ? c : '_';
    changed = changed || !safe;
  }
  if (changed) name += fmt::format("-{:016x}", checksumOf(std::as_bytes(std::span(what))));
  return name + ".idx";
}

// The size in bytes of a regular file; nullopt for any other.
std::optional<uint64_t> sizeOf(const Descriptor& file) {
  struct stat status {};
  if (!file || fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return static_cast<uint64_t>(status.st_size);
}

struct Verdict {
  IndexState state = IndexState::kTorn;
  std::string reason;
  std::vector<std::byte> blob;
};

Verdict readFile(const std::filesystem::path& path, const IndexKey& key) {
  // Opened without blocking, because the path may be a pipe.
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  // A missing file is no reason for a note; anything else is. No file has a name that is too long,
  // as that of an index beside a volume with a long name is.
  if (!file && (errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG))
    return {IndexState::kMissing, "", {}};
  const std::optional<uint64_t> size = sizeOf(file);
  if (!size) return {IndexState::kTorn, "not a file that can be read", {}};
  Header header;
  if (*size < sizeof header || !readAll(file.get(), std::as_writable_bytes(std::span(&header, 1))))
    return {IndexState::kTorn, "shorter than its header", {}};
  const Header ours;
  if (header.magic != ours.magic) return {IndexState::kTorn, "not an index", {}};
  if (header.container_version != ours.container_version)
    return {IndexState::kStale, "of another version of sluice", {}};
  // This check comes before any allocation: the lengths make up the file's size exactly.
  const uint64_t key_bytes = uint64_t{header.identity_bytes} + header.what_bytes;
  const uint64_t rest = *size - sizeof header;
  if (key_bytes > rest || header.blob_bytes != rest - key_bytes)
    return {IndexState::kTorn, "its length differs from the length in its header", {}};
  std::string key_text(key_bytes, '\0');
  if (!readAll(file.get(), std::as_writable_bytes(std::span(key_text))))
    return {IndexState::kTorn, "cut short", {}};
  Header expected;
  // The checksum covers the header, with 0 in the place of the checksum, and the key.
  std::memcpy(&expected, headerAndKey(header, key_text).data(), sizeof expected);
  if (header.header_checksum != expected.header_checksum)
    return {IndexState::kTorn, "damaged in its header", {}};
  if (header.identity_bytes != key.identity.size() || key_text != key.identity + key.what)
    return {IndexState::kStale, "of another state of the volume", {}};
  if (header.key_version != key.version)
    return {IndexState::kStale, "of another version of sluice", {}};
  Verdict verdict;
  // Large pages, because fresh memory costs as much as reading into it.
  reserveLarge(verdict.blob, header.blob_bytes);
  verdict.blob.resize(header.blob_bytes);
  if (!readAll(file.get(), verdict.blob)) return {IndexState::kTorn, "cut short", {}};
  if (checksumOf(verdict.blob) != header.blob_checksum) return {IndexState::kTorn, "damaged", {}};
  verdict.state = IndexState::kFound;
  return verdict;
}

void writeFile(const std::filesystem::path& path, const IndexKey& key,
               std::span<const std::byte> blob) {
  Header header;
  header.key_version = key.version;
  header.identity_bytes = static_cast<uint32_t>(key.identity.size());
  header.what_bytes = static_cast<uint32_t>(key.what.size());
  header.blob_bytes = blob.size();
  header.blob_checksum = checksumOf(blob);
  // Readers see the old file or the new one, and two writers never mix.
  AtomicFile file(path);
  file.write(headerAndKey(header, key.identity + key.what));
  file.write(blob);
  file.commit();
}

// A volume's own folder in that for all of them.
std::string folderName(const std::string& full_name) {
  std::string stem = fileName(std::filesystem::path(full_name).filename().string().substr(0, 60));
  stem.resize(stem.size() - std::string_view(".idx").size());
  return fmt::format("{}-{:016x}", stem, checksumOf(std::as_bytes(std::span(full_name))));
}

}  // namespace

std::string selectionOf(const VolumeLayout& volume, int64_t time) {
  const std::string channel = volume.channels > 1 ? fmt::format("-c{}", volume.channel) : "";
  return fmt::format("{}-{}x{}x{}-{}{}-t{}of{}", name(volume.type), volume.dims.x, volume.dims.y,
                     volume.dims.z, volume.name, channel, time, volume.time_steps);
}

IndexPlaces indexPlaces(const std::string& volume, const IndexWish& wish) {
  IndexPlaces places;
  places.disabled = wish.disabled;
  if (places.disabled) return places;
  std::error_code ignored;
  // The full name without trailing slashes, so that one folder has one index whatever the way to
  // it.
  std::string full = volume;
  std::filesystem::path beside;
  if (!isSynthSpec(volume)) {
    full = withoutSlashes(std::filesystem::absolute(volume, ignored).lexically_normal().native());
    beside = full + ".sluice-index";
  }
  if (!wish.folder.empty()) {
    const auto all = std::filesystem::absolute(wish.folder, ignored).lexically_normal();
    places.folders.push_back(all / folderName(full));
    places.written = places.folders.front();
  }
  if (!beside.empty()) {
    // The first folder that has an index is read. New ones go to one place only.
    places.folders.insert(wish.beside ? places.folders.begin() : places.folders.end(), beside);
    if (wish.beside) places.written = beside;
  }
  return places;
}

std::string_view name(IndexState state) {
  constexpr std::array<std::string_view, 5> kNames = {"found", "missing", "stale", "torn",
                                                      "disabled"};
  return kNames[static_cast<size_t>(state)];
}

std::string_view name(IndexOrigin origin) {
  constexpr std::array<std::string_view, 4> kNames = {"read", "built", "built, not kept",
                                                      "not made"};
  return kNames[static_cast<size_t>(origin)];
}

IndexRead readIndex(const IndexPlaces& places, const IndexKey& key) {
  IndexRead result;
  if (places.disabled) result.state = IndexState::kDisabled;
  for (const std::filesystem::path& folder : places.folders) {
    const std::filesystem::path path = folder / fileName(key.what);
    Verdict verdict = readFile(path, key);
    if (verdict.state == IndexState::kFound)
      return {IndexState::kFound, std::move(verdict.blob), path, ""};
    // The first index that cannot be used is noted, in case none can.
    if (verdict.state != IndexState::kMissing && result.state == IndexState::kMissing)
      result = {verdict.state, std::nullopt, path,
                fmt::format("{}: {}, not used", path.string(), verdict.reason)};
  }
  return result;
}

bool removeIndices(const std::filesystem::path& folder) {
  std::error_code status;
  std::vector<std::filesystem::path> files;
  // Only names of ours are removed: the folder may be the user's.
  for (std::filesystem::directory_iterator it(folder, status), end; !status && it != end;
       it.increment(status))
    if (it->path().extension() == ".idx") files.push_back(it->path());
  bool all = !status;
  for (const std::filesystem::path& file : files) {
    std::filesystem::remove(file, status);
    all = all && !status;
  }
  return all;
}

IndexWritten writeIndex(const IndexPlaces& places, const IndexKey& key,
                        std::span<const std::byte> blob) {
  IndexWritten result;
  if (places.disabled)
    result.note = "the index is disabled (SLUICE_INDEX=off)";
  else if (places.written.empty())
    result.note = "no index is kept: name a folder for it (--index-dir, SLUICE_INDEX_DIR, HOME)";
  if (!result.note.empty()) return result;
  // The status is looked at inside the try, so that all failures become a note.
  std::error_code status;
  std::filesystem::create_directories(places.written, status);
  try {
    if (status) failSystem("{}: {}", places.written.string(), status.message());
    const std::filesystem::path path = places.written / fileName(key.what);
    writeFile(path, key, blob);
    result.path = path;
  } catch (const Error& error) {
    result.note =
        fmt::format("no index is kept: {} (--index-dir names another folder)", error.what());
  }
  return result;
}

}  // namespace sluice
