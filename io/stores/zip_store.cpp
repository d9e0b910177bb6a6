#include "io/stores/zip_store.h"

#include <zlib.h>

#include <algorithm>
#include <vector>

#include "io/files/inflater.h"
#include "src/base/error.h"
#include "src/base/values/text_parts.h"

namespace sluice {
namespace {

// A part of a deflated entry is decoded from the entry's start on: parts of longer ones are
// refused.
constexpr uint64_t kMostDecodedAgain = 4 << 20;

// The checksum of bytes that follow those of `before`.
uint32_t checksumOf(std::span<const std::byte> bytes, uint32_t before = 0) {
  if (bytes.empty()) return before;
  return static_cast<uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace

ZipStore::ZipStore(const std::filesystem::path& path)
    : file_(std::make_shared<File>(path)), directory_(*file_), identity_(file_->identity()) {}

std::string ZipStore::wholeKey(const std::string& key) const {
  const std::string normal = std::filesystem::path("/" + key).lexically_normal().string();
  return std::string(withoutSlashes(normal).substr(1));
}

bool ZipStore::has(const std::string& key) {
  const std::string whole = wholeKey(key);
  if (whole.empty() || directory_.find(whole)) return true;
  const size_t i = directory_.firstFrom(whole + '/');
  return i < directory_.size() && directory_.at(i).key.starts_with(whole + '/');
}

uint32_t ZipStore::inflateInto(const ZipEntry& entry, uint64_t from, std::span<std::byte> out) {
  Inflater inflater(file_, contentOf(*file_, entry), entry.stored_bytes);
  // Deflate has no way in but its start.
  std::vector<std::byte> before(from);
  for (const std::span<std::byte> part : {std::span(before), out})
    if (inflater.read(part) < part.size())
      fail("{}: expected {} bytes once decoded, found fewer; write or fetch it again",
           nameOf(std::string(entry.key)), entry.bytes);
  return checksumOf(out, checksumOf(before));
}

bool ZipStore::read(const std::string& key, const PieceBytes& wanted, const Room& room) {
  const std::optional<ZipEntry> entry = directory_.find(wholeKey(key));
  if (!entry) return false;
  const std::span<std::byte> out = room({entry->bytes, false});
  uint64_t from = wanted.from == PieceBytes::From::kStart ? wanted.offset : 0;
  if (from > entry->bytes || out.size() > entry->bytes - from)
    fail("{}: expected {} bytes, found {}; it was cut short", nameOf(key), from + out.size(),
         entry->bytes);
  if (wanted.from == PieceBytes::From::kEnd) from = entry->bytes - out.size();
  const bool is_all = out.size() == entry->bytes;
  if (entry->is_deflated && !is_all && entry->bytes > kMostDecodedAgain)
    fail(
        "{}: expected an entry that is stored, of which parts are read, found {} deflated bytes; "
        "unpack the zip file, or make it without compression",
        nameOf(key), entry->bytes);
  uint32_t checksum = 0;
  if (entry->is_deflated) {
    checksum = inflateInto(*entry, from, out);
  } else {
    file_->readAt(contentOf(*file_, *entry) + from, out);
    if (is_all) checksum = checksumOf(out);
  }
  // Only all bytes from the first one on have the checksum of the entry.
  const bool is_known = entry->is_deflated ? from + out.size() == entry->bytes : is_all;
  if (is_known && checksum != entry->checksum)
    fail("{}: expected the checksum {:08x}, found {:08x}; write or fetch it again", nameOf(key),
         entry->checksum, checksum);
  return true;
}

std::string ZipStore::stampOf(const std::string& key) {
  return has(key) ? identity_ : "none";
}

void ZipStore::list(const std::string& folder,
                    const std::function<void(const Entry& entry)>& take) {
  const std::string whole = wholeKey(folder), before = whole.empty() ? "" : whole + '/';
  size_t i = directory_.firstFrom(before);
  while (i < directory_.size() && directory_.at(i).key.starts_with(before)) {
    const std::string_view rest = directory_.at(i).key.substr(before.size());
    const size_t end = rest.find('/');
    take({std::string(rest.substr(0, end)), end != rest.npos});
    // All entries of a folder are less than its name with '0', which follows '/'.
    i = end == rest.npos ? i + 1
                         : directory_.firstFrom(before + std::string(rest.substr(0, end)) + '0');
  }
}

StorePlace zipPlace(const std::filesystem::path& path, const std::string& inside) {
  StorePlace place{std::make_shared<ZipStore>(path), ""};
  place.key = place.store->wholeKey(inside);
  if (!place.key.empty()) return place;
  // The store may lie in a folder, alone: people zip the folder around a store, too.
  while (!isStore(place)) {
    std::vector<std::string> folders;
    place.store->list(place.key, [&](const ChunkStore::Entry& entry) {
      if (entry.is_folder && entry.name != "__MACOSX") folders.push_back(entry.name);
    });
    if (folders.size() != 1) return place;
    place = place.at(folders.front());
  }
  return place;
}

}  // namespace sluice
