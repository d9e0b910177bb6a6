#include "io/stores/zip_directory.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

#include "src/base/error.h"

namespace sluice {
namespace {

static_assert(std::endian::native == std::endian::little);  // as zip files are

constexpr uint32_t kEndMark = 0x06054b50, kWideLocatorMark = 0x07064b50, kWideEndMark = 0x06064b50,
                   kEntryMark = 0x02014b50, kHeaderMark = 0x04034b50;
constexpr uint64_t kHeaderBytes = 30, kEndBytes = 22, kWideLocatorBytes = 20, kWideEndBytes = 56,
                   kEntryBytes = 46, kMostComment = 0xFFFF;
constexpr uint32_t kWide32 = 0xFFFFFFFF;  // the number stands elsewhere, in 64 bits
constexpr uint16_t kWide16 = 0xFFFF, kWideExtra = 1;

// Requires: the number lies in `bytes`.
template <class Number>
Number numberAt(std::span<const std::byte> bytes, uint64_t offset) {
  Number number;
  std::memcpy(&number, bytes.data() + offset, sizeof(number));
  return number;
}

struct DirectoryPlace {
  uint64_t offset = 0, bytes = 0, entries = 0;
};

// Finds the end of the list: its last mark behind which the comment ends with the file.
std::optional<uint64_t> endIn(std::span<const std::byte> tail) {
  if (tail.size() < kEndBytes) return std::nullopt;
  for (uint64_t at = tail.size() - kEndBytes;; --at) {
    if (numberAt<uint32_t>(tail, at) == kEndMark &&
        at + kEndBytes + numberAt<uint16_t>(tail, at + 20) == tail.size())
      return at;
    if (at == 0) return std::nullopt;
  }
}

// The same in 64 bits, if there is one in front of it.
std::optional<DirectoryPlace> wideDirectory(File& file, uint64_t end_at) {
  if (end_at < kWideLocatorBytes) return std::nullopt;
  std::vector<std::byte> locator(kWideLocatorBytes), end(kWideEndBytes);
  file.readAt(end_at - kWideLocatorBytes, locator);
  if (numberAt<uint32_t>(locator, 0) != kWideLocatorMark) return std::nullopt;
  const auto at = numberAt<uint64_t>(locator, 8);
  // Offsets come from the file, so each is checked before it is read from.
  if (end_at < kWideEndBytes || at > end_at - kWideEndBytes)
    fail("{}: expected the end of its list of files within {} bytes, found it at {}", file.path(),
         end_at, at);
  file.readAt(at, end);
  if (numberAt<uint32_t>(end, 0) != kWideEndMark)
    fail("{}: expected the end of its list of files at {}, found other bytes", file.path(), at);
  return DirectoryPlace{numberAt<uint64_t>(end, 48), numberAt<uint64_t>(end, 40),
                        numberAt<uint64_t>(end, 32)};
}

DirectoryPlace findDirectory(File& file) {
  const uint64_t size = file.sizeBytes();
  // A comment of up to 64 KiB may follow the end record (APPNOTE 4.3.16).
  std::vector<std::byte> tail(std::min(size, kEndBytes + kMostComment));
  file.readAt(size - tail.size(), tail);
  const std::optional<uint64_t> found = endIn(tail);
  if (!found)
    fail(
        "{}: expected a zip file's list of files at its end, found other bytes; it was cut short, "
        "or bytes were added behind it: write or fetch it again",
        file.path());
  const auto end = std::span<const std::byte>(tail).subspan(*found);
  const uint64_t end_at = size - end.size();
  const auto parts = numberAt<uint16_t>(end, 4);
  DirectoryPlace place{numberAt<uint32_t>(end, 16), numberAt<uint32_t>(end, 12),
                       numberAt<uint16_t>(end, 10)};
  // Numbers that do not fit stand in the Zip64 end record (APPNOTE 4.3.14).
  if (place.offset == kWide32 || place.bytes == kWide32 || place.entries == kWide16)
    place = wideDirectory(file, end_at).value_or(place);
  if (parts != 0 && parts != kWide16)
    fail("{}: expected a zip file of one part, found part {}; join the parts first", file.path(),
         parts + 1);
  if (place.offset > end_at || place.bytes > end_at - place.offset)
    fail("{}: expected the list of files within {} bytes, found {} bytes at {}", file.path(),
         end_at, place.bytes, place.offset);
  if (place.bytes > ZipDirectory::kMostBytes)
    fail("{}: expected a list of files of at most {} bytes, found {}; unpack the zip file first",
         file.path(), ZipDirectory::kMostBytes, place.bytes);
  return place;
}

}  // namespace

bool isZip(std::string_view head) {
  return head.starts_with("PK\x03\x04") || head.starts_with("PK\x05\x06");
}

uint64_t contentOf(File& file, const ZipEntry& entry) {
  const uint64_t size = file.sizeBytes();
  std::vector<std::byte> header(kHeaderBytes + entry.name.size());
  if (header.size() <= size - entry.header_at) {
    // The local header's extra field may have another length than the directory's, so that only it
    // tells where the content begins.
    file.readAt(entry.header_at, header);
    const auto name_bytes = numberAt<uint16_t>(header, 26), more = numberAt<uint16_t>(header, 28);
    const uint64_t at = entry.header_at + kHeaderBytes + name_bytes + more;
    const std::string_view name(reinterpret_cast<const char*>(header.data()) + kHeaderBytes,
                                entry.name.size());
    if (numberAt<uint32_t>(header, 0) == kHeaderMark && name_bytes == name.size() &&
        name == entry.name && at <= size && entry.stored_bytes <= size - at)
      return at;
  }
  fail("{}/{}: expected its header and {} bytes at {}, found other bytes; write or fetch it again",
       file.path(), entry.key, entry.stored_bytes, entry.header_at);
}

ZipDirectory::ZipDirectory(File& file) {
  const DirectoryPlace place = findDirectory(file);
  bytes_.resize(place.bytes);
  file.readAt(place.offset, bytes_);
  uint64_t read = 0;
  for (uint64_t at = 0; at < bytes_.size(); ++read) {
    const uint64_t left = bytes_.size() - at;
    if (left < kEntryBytes || numberAt<uint32_t>(bytes_, at) != kEntryMark)
      fail(
          "{}: expected {} entries in the list of files, found other bytes after {}; write or "
          "fetch it again",
          file.path(), place.entries, read);
    const uint64_t all = kEntryBytes + numberAt<uint16_t>(bytes_, at + 28) +
                         numberAt<uint16_t>(bytes_, at + 30) + numberAt<uint16_t>(bytes_, at + 32);
    if (all > left)
      fail(
          "{}: expected entry {} of the list of files within it, found it cut short; write or "
          "fetch it again",
          file.path(), read);
    const ZipEntry entry = entryAt(at);
    if (!entry.key.empty() && !entry.key.ends_with('/')) {
      constexpr uint16_t kEncrypted = 1;
      const auto method = numberAt<uint16_t>(bytes_, at + 10);
      if ((numberAt<uint16_t>(bytes_, at + 8) & kEncrypted) != 0)
        fail("{}/{}: expected an entry without a password, found an encrypted one", file.path(),
             entry.key);
      if (method != 0 && method != 8)
        fail(
            "{}/{}: expected an entry that is stored or deflated, found method {}; unpack the zip "
            "file first",
            file.path(), entry.key, method);
      if (entry.header_at > file.sizeBytes() ||
          entry.stored_bytes > file.sizeBytes() - entry.header_at ||
          (!entry.is_deflated && entry.stored_bytes != entry.bytes))
        fail("{}/{}: expected its bytes within the zip file, found {} at {}", file.path(),
             entry.key, entry.stored_bytes, entry.header_at);
      entries_.push_back(at);
    }
    at += all;
  }
  // Some writers count in 16 bits alone.
  if (read != place.entries && (place.entries > kWide16 || (read & kWide16) != place.entries))
    fail("{}: expected {} entries in the list of files, found {}; write or fetch it again",
         file.path(), place.entries, read);
  std::ranges::stable_sort(entries_, {}, [this](uint64_t at) { return entryAt(at).key; });
  // The last of equal entries stays: a writer that replaces an entry appends another.
  const auto same = [this](uint64_t a, uint64_t b) { return entryAt(a).key == entryAt(b).key; };
  const auto first = std::unique(entries_.rbegin(), entries_.rend(), same).base();
  entries_.erase(entries_.begin(), first);
}

ZipEntry ZipDirectory::entryAt(uint64_t offset) const {
  const std::span<const std::byte> bytes = std::span(bytes_).subspan(offset);
  const auto key_bytes = numberAt<uint16_t>(bytes, 28), extra_bytes = numberAt<uint16_t>(bytes, 30);
  ZipEntry entry{
      .name = {reinterpret_cast<const char*>(bytes.data()) + kEntryBytes, key_bytes},
      .key = {},
      .is_deflated = numberAt<uint16_t>(bytes, 10) == 8,
      .checksum = numberAt<uint32_t>(bytes, 16),
      .stored_bytes = numberAt<uint32_t>(bytes, 20),
      .bytes = numberAt<uint32_t>(bytes, 24),
      .header_at = numberAt<uint32_t>(bytes, 42),
  };
  entry.key = entry.name;
  for (const std::string_view before : {"./", "/"})
    while (entry.key.starts_with(before)) entry.key.remove_prefix(before.size());
  // Numbers that do not fit into 32 bits, in this order, those that do left out.
  std::span<const std::byte> extra = bytes.subspan(kEntryBytes + key_bytes, extra_bytes);
  while (extra.size() >= 4) {
    const auto kind = numberAt<uint16_t>(extra, 0), size = numberAt<uint16_t>(extra, 2);
    if (size > extra.size() - 4) break;
    std::span<const std::byte> numbers = extra.subspan(4, size);
    if (kind == kWideExtra) {
      for (uint64_t* number : {&entry.bytes, &entry.stored_bytes, &entry.header_at}) {
        if (*number != kWide32 || numbers.size() < 8) continue;
        *number = numberAt<uint64_t>(numbers, 0);
        numbers = numbers.subspan(8);
      }
    }
    extra = extra.subspan(4 + size);
  }
  return entry;
}

size_t ZipDirectory::firstFrom(std::string_view key) const {
  const auto found =
      std::ranges::lower_bound(entries_, key, {}, [this](uint64_t at) { return entryAt(at).key; });
  return static_cast<size_t>(found - entries_.begin());
}

std::optional<ZipEntry> ZipDirectory::find(std::string_view key) const {
  const size_t i = firstFrom(key);
  if (i == size() || at(i).key != key) return std::nullopt;
  return at(i);
}

}  // namespace sluice
