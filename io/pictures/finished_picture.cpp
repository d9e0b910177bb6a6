#include "io/pictures/finished_picture.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "io/files/file.h"

namespace sluice {
namespace {

using Size = std::array<int64_t, 2>;

// PNG, section 5.2: the signature, and the chunks of the header and the end (5.3).
constexpr std::string_view kPngBegin("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
constexpr std::string_view kPngEnd("\0\0\0\0IEND\xae\x42\x60\x82", 12);
// OpenEXR's file layout: the magic number.
constexpr std::string_view kExrBegin("\x76\x2f\x31\x01", 4);

// The bytes of a file from `offset` on, at most `most` of them.
std::string bytesAt(File& file, uint64_t offset, size_t most) {
  std::string bytes(most, '\0');
  if (offset >= file.sizeBytes()) return {};
  bytes.resize(file.readSome(offset, std::as_writable_bytes(std::span(bytes))));
  return bytes;
}

int64_t bigEndian(std::string_view four) {
  int64_t number = 0;
  for (const char byte : four) number = number * 256 + static_cast<uint8_t>(byte);
  return number;
}

template <class T>
T littleEndian(std::string_view bytes) {
  std::make_unsigned_t<T> number = 0;
  for (size_t i = sizeof(T); i-- > 0;) number = (number << 8) | static_cast<uint8_t>(bytes[i]);
  return static_cast<T>(number);
}

std::optional<Size> sizeOfPng(File& file, std::string_view begin) {
  if (begin.size() < kPngBegin.size() + 8 ||
      bytesAt(file, file.sizeBytes() - kPngEnd.size(), kPngEnd.size()) != kPngEnd)
    return std::nullopt;
  return Size{bigEndian(begin.substr(16, 4)), bigEndian(begin.substr(20, 4))};
}

// The value of an attribute of the header, and where the header ends.
struct ExrHeader {
  std::string_view data_window, compression;
  size_t end = 0;
};

std::optional<ExrHeader> headerOf(std::string_view bytes) {
  ExrHeader header;
  size_t at = kExrBegin.size() + 4;
  while (at < bytes.size() && bytes[at] != '\0') {
    const size_t name_end = bytes.find('\0', at);
    const size_t type_end = bytes.find('\0', std::min(name_end, bytes.size() - 1) + 1);
    if (type_end == bytes.npos || type_end + 5 > bytes.size()) return std::nullopt;
    const std::string_view name = bytes.substr(at, name_end - at);
    const auto size = littleEndian<uint32_t>(bytes.substr(type_end + 1, 4));
    at = type_end + 5;
    if (size > bytes.size() - at) return std::nullopt;
    if (name == "dataWindow" && size == 16) header.data_window = bytes.substr(at, size);
    if (name == "compression" && size == 1) header.compression = bytes.substr(at, size);
    at += size;
  }
  header.end = at + 1;
  if (header.end > bytes.size() || header.data_window.empty() || header.compression.empty())
    return std::nullopt;
  return header;
}

// The EXR has scan lines, as sluice writes them: a table of offsets follows the header, and each
// chunk is its row, its size and as many bytes.
std::optional<Size> sizeOfExr(File& file) {
  // More than the texts in a header take.
  constexpr size_t kMostHeader = size_t{1} << 22;
  const std::string bytes = bytesAt(file, 0, std::min<uint64_t>(file.sizeBytes(), kMostHeader));
  const auto header = headerOf(bytes);
  if (!header) return std::nullopt;
  std::array<int64_t, 4> corners{};  // first column and row, last column and row
  for (size_t i = 0; i < 4; ++i)
    corners[i] = littleEndian<int32_t>(header->data_window.substr(4 * i, 4));
  const Size size{corners[2] - corners[0] + 1, corners[3] - corners[1] + 1};
  if (size[0] < 1 || size[1] < 1) return std::nullopt;
  // Rows of a chunk: none, RLE and ZIPS have one; ZIP has 16.
  const int64_t rows = header->compression[0] == 3 ? 16 : 1;
  const auto chunks = static_cast<uint64_t>((size[1] + rows - 1) / rows);
  const std::string last = bytesAt(file, header->end + 8 * (chunks - 1), 8);
  if (last.size() < 8) return std::nullopt;
  const auto offset = littleEndian<uint64_t>(last);
  const std::string chunk = bytesAt(file, offset, 8);
  if (offset == 0 || chunk.size() < 8) return std::nullopt;
  const uint64_t stored = littleEndian<uint32_t>(std::string_view(chunk).substr(4));
  if (stored == 0 || offset + 8 + stored > file.sizeBytes()) return std::nullopt;
  return size;
}

}  // namespace

std::optional<Size> sizeOfWholePicture(const std::filesystem::path& path) {
  std::error_code status;
  if (!std::filesystem::is_regular_file(path, status)) return std::nullopt;
  File file(path);
  const std::string begin = bytesAt(file, 0, kPngBegin.size() + 8);
  if (begin.starts_with(kPngBegin)) return sizeOfPng(file, begin);
  if (begin.starts_with(kExrBegin)) return sizeOfExr(file);
  return std::nullopt;
}

}  // namespace sluice
