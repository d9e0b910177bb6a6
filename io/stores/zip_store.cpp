#include "io/stores/zip_store.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint32_t kHeaderMark = 0x04034b50;
constexpr uint64_t kHeaderBytes = 30;
// Of longer entries no part is read if they are deflated: each would be decoded from its start on.
constexpr uint64_t kMostDecodedAgain = 4 << 20;

// A stream of deflated bytes without a header.
struct RawInflate {
  explicit RawInflate(const std::string& name) {
    if (inflateInit2(&stream, -MAX_WBITS) != Z_OK)
      failMemory("{}: not enough memory to decode it", name);
  }
  ~RawInflate() { inflateEnd(&stream); }
  RawInflate(const RawInflate&) = delete;
  RawInflate& operator=(const RawInflate&) = delete;
  z_stream stream = {};
};

}  // namespace

ZipStore::ZipStore(const std::filesystem::path& path)
    : file_(path), directory_(file_), identity_(file_.identity()) {}

std::string ZipStore::wholeKey(const std::string& key) const {
  std::string whole = std::filesystem::path("/" + key).lexically_normal().string().substr(1);
  while (whole.ends_with('/')) whole.pop_back();
  return whole;
}

bool ZipStore::has(const std::string& key) {
  const std::string whole = wholeKey(key);
  if (whole.empty() || directory_.find(whole)) return true;
  const size_t i = directory_.firstFrom(whole + '/');
  return i < directory_.size() && directory_.at(i).key.starts_with(whole + '/');
}

uint64_t ZipStore::contentAt(const ZipEntry& entry) {
  const std::string name = nameOf(std::string(entry.key));
  std::vector<std::byte> header(kHeaderBytes + entry.name.size());
  const uint64_t file_bytes = file_.sizeBytes();
  uint32_t mark = 0;
  std::array<uint16_t, 2> lengths{};  // of the name, and of what follows it
  if (header.size() <= file_bytes - entry.header_at) {
    file_.readAt(entry.header_at, header);
    std::memcpy(&mark, header.data(), sizeof(mark));
    std::memcpy(lengths.data(), header.data() + 26, sizeof(lengths));
  }
  const uint64_t at = entry.header_at + kHeaderBytes + lengths[0] + lengths[1];
  const auto is_named = [&] {
    return lengths[0] == entry.name.size() &&
           std::memcmp(header.data() + kHeaderBytes, entry.name.data(), entry.name.size()) == 0;
  };
  if (mark != kHeaderMark || !is_named() || at > file_bytes || entry.stored_bytes > file_bytes - at)
    fail("{}: expected its header and {} bytes at {}, found other bytes; write or fetch it again",
         name, entry.stored_bytes, entry.header_at);
  return at;
}

void ZipStore::inflateInto(const ZipEntry& entry, uint64_t from, std::span<std::byte> out) {
  constexpr uint64_t kPart = 256 << 10;
  const std::string name = nameOf(std::string(entry.key));
  RawInflate inflater(name);
  z_stream& stream = inflater.stream;
  std::vector<std::byte> stored(std::min(entry.stored_bytes, kPart)), skipped;
  skipped.resize(std::min(from, kPart));
  const uint64_t content_at = contentAt(entry);
  uint64_t taken = 0, decoded = 0;
  auto checksum = static_cast<uint32_t>(crc32(0, nullptr, 0));
  while (decoded < from + out.size()) {
    if (stream.avail_in == 0 && taken < entry.stored_bytes) {
      const auto part = std::span(stored).first(std::min(kPart, entry.stored_bytes - taken));
      file_.readAt(content_at + taken, part);
      taken += part.size();
      stream.next_in = reinterpret_cast<Bytef*>(part.data());
      stream.avail_in = static_cast<uInt>(part.size());
    }
    const std::span<std::byte> room =
        decoded < from
            ? std::span(skipped).first(std::min(kPart, from - decoded))
            : out.subspan(decoded - from, std::min<uint64_t>(1 << 30, from + out.size() - decoded));
    stream.next_out = reinterpret_cast<Bytef*>(room.data());
    stream.avail_out = static_cast<uInt>(room.size());
    const int status = inflate(&stream, Z_NO_FLUSH);
    const uint64_t got = room.size() - stream.avail_out;
    checksum = static_cast<uint32_t>(
        crc32(checksum, reinterpret_cast<const Bytef*>(room.data()), static_cast<uInt>(got)));
    decoded += got;
    const bool goes_on = status == Z_OK && (got > 0 || stream.avail_in == 0) &&
                         (got > 0 || taken < entry.stored_bytes);
    if (!goes_on && decoded < from + out.size())
      fail("{}: expected {} bytes once decoded, found damage after {}; write or fetch it again",
           name, entry.bytes, decoded);
  }
  if (decoded == entry.bytes && checksum != entry.checksum)
    fail("{}: expected the checksum {:08x}, found {:08x}; write or fetch it again", name,
         entry.checksum, checksum);
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
  if (entry->is_deflated) {
    if (out.size() < entry->bytes && entry->bytes > kMostDecodedAgain)
      fail(
          "{}: expected an entry that is stored, of which parts are read, found {} deflated bytes; "
          "unpack the zip file, or make it without compression",
          nameOf(key), entry->bytes);
    inflateInto(*entry, from, out);
    return true;
  }
  file_.readAt(contentAt(*entry) + from, out);
  if (out.size() != entry->bytes) return true;
  uLong checksum = crc32(0, nullptr, 0);
  checksum = crc32_z(checksum, reinterpret_cast<const Bytef*>(out.data()), out.size());
  if (checksum != entry->checksum)
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
    // Behind a folder's entries comes what is greater than all of them: '0' follows '/'.
    i = end == rest.npos ? i + 1
                         : directory_.firstFrom(before + std::string(rest.substr(0, end)) + '0');
  }
}

StorePlace zipPlace(const std::filesystem::path& path, const std::string& inside) {
  StorePlace place{std::make_shared<ZipStore>(path), ""};
  place.key = place.store->wholeKey(inside);
  if (!place.key.empty()) return place;
  // Down to the first folder that holds more than one: people zip the folder around a store, too.
  constexpr std::array kMetadata{"zarr.json", ".zgroup", ".zarray", ".zattrs", "attributes.json"};
  for (;;) {
    if (std::ranges::any_of(kMetadata, [&](const char* name) { return place.has(name); }))
      return place;
    std::vector<std::string> folders;
    place.store->list(place.key, [&](const ChunkStore::Entry& entry) {
      if (entry.is_folder && entry.name != "__MACOSX") folders.push_back(entry.name);
    });
    if (folders.size() != 1) return place;
    place = place.at(folders.front());
  }
}

}  // namespace sluice
