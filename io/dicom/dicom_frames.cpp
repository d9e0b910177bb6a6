#include "io/dicom/dicom_frames.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include "src/base/error.h"

namespace sluice {
namespace {

constexpr uint64_t kItemBytes = 8;

uint32_t littleAt(std::span<const std::byte> bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) value |= std::to_integer<uint32_t>(bytes[at + i]) << 8 * i;
  return value;
}
uint32_t bigAt(std::span<const std::byte> bytes, size_t at, size_t count) {
  uint32_t value = 0;
  for (size_t i = 0; i < count; ++i) value = value << 8 | std::to_integer<uint32_t>(bytes[at + i]);
  return value;
}

// A frame of `bytes` is never compressed to more than this.
uint64_t mostCodeBytes(uint64_t frame_bytes) {
  constexpr uint64_t kBeside = uint64_t{1} << 20;
  return 2 * frame_bytes + kBeside;
}

std::vector<DicomPlace> plainPlaces(const DicomInput& input, const DicomHeader& header) {
  const uint64_t frame = header.frameBytes();
  const auto frames = static_cast<uint64_t>(header.frames);
  const uint64_t found = std::min(header.pixels_length, input.bytes - header.pixels_at);
  // Divided, since the product of a damaged header may exceed 64 bits.
  if (frame > found / frames)
    fail(
        "{}: {} x {} pixels x {} frames x {} bytes = {} bytes expected, {} found; the file was cut "
        "short or its header is wrong",
        input.path, header.columns, header.rows, frames, frame / (header.columns * header.rows),
        frame * frames, found);
  std::vector<DicomPlace> places(frames);
  for (uint64_t i = 0; i < frames; ++i) {
    places[i].begin = header.pixels_at + i * frame;
    places[i].end = places[i].begin + frame;
  }
  return places;
}

// Fragments, and the table in front of them.
struct Fragments {
  std::vector<uint64_t> table;  // of each frame, behind first_at
  uint64_t first_at = 0;        // of the first fragment's header
  std::vector<DicomPlace> all;  // with their headers
};

Fragments listFragments(const DicomInput& input, const DicomHeader& header) {
  constexpr size_t kMostFragments = size_t{1} << 21;
  Fragments fragments;
  DicomElements items(input, header.pixels_at, {});
  const auto table = items.next(input.bytes);
  // table->tag != kDicomItem| The first item is the basic offset table, which may be empty (PS3.5,
  // A.4).
  if (!table || table->tag != kDicomItem || table->isUndefined())
    fail("{}: damaged DICOM file: its compressed pixels have no table of offsets", input.path);
  if (table->length == 4 * header.frames) {
    std::vector<std::byte> bytes(table->length);
    input.readSome(table->at, bytes);
    for (size_t i = 0; i < bytes.size(); i += 4) fragments.table.push_back(littleAt(bytes, i));
  }
  items.skip(*table);
  fragments.first_at = items.position();
  for (;;) {
    const uint64_t at = items.position();
    const auto item = items.next(input.bytes);
    if (item && item->tag == kDicomSequenceEnd) break;
    if (!item || item->tag != kDicomItem || item->isUndefined() ||
        fragments.all.size() >= kMostFragments)
      fail(
          "{}: damaged DICOM file: no fragment of pixels and no end of them at {}; it was cut "
          "short",
          input.path, at);
    fragments.all.push_back({at, item->at + item->length});
    items.skip(*item);
  }
  return fragments;
}

// Frames begin where the table says.
std::optional<std::vector<DicomPlace>> placesByTable(const Fragments& f) {
  if (f.table.empty() || f.all.empty()) return std::nullopt;
  std::vector<DicomPlace> places;
  size_t fragment = 0;
  for (size_t i = 0; i < f.table.size(); ++i) {
    const uint64_t begin = f.first_at + f.table[i];
    const uint64_t end = i + 1 < f.table.size() ? f.first_at + f.table[i + 1] : f.all.back().end;
    // Some writers fill the table with wrong offsets: then the streams' markers tell where frames
    // begin.
    if (fragment >= f.all.size() || f.all[fragment].begin != begin) return std::nullopt;
    while (fragment < f.all.size() && f.all[fragment].begin < end) ++fragment;
    if (f.all[fragment - 1].end != end) return std::nullopt;
    places.push_back({begin, end});
  }
  return places;
}

// A fragment that begins with a stream's first marker begins a frame.
std::vector<DicomPlace> placesByMarkers(const DicomInput& input, const Fragments& f) {
  std::vector<DicomPlace> places;
  for (const DicomPlace& fragment : f.all) {
    std::array<std::byte, 4> first{};
    input.readSome(fragment.begin + kItemBytes, first);
    const uint32_t marker = bigAt(first, 0, 2);
    if (places.empty() || marker == 0xFFD8 || marker == 0xFF4F)
      places.push_back(fragment);
    else
      places.back().end = fragment.end;
  }
  return places;
}

std::vector<DicomPlace> fragmentPlaces(const DicomInput& input, const DicomHeader& header) {
  const Fragments f = listFragments(input, header);
  const auto frames = static_cast<size_t>(header.frames);
  if (f.all.size() == frames) return f.all;
  if (frames == 1 && !f.all.empty()) return {{f.all.front().begin, f.all.back().end}};
  if (auto places = placesByTable(f)) return std::move(*places);
  if (header.coding != DicomCoding::kRunLength) {
    std::vector<DicomPlace> places = placesByMarkers(input, f);
    if (places.size() == frames) return places;
  }
  fail("{}: damaged DICOM file: {} fragments for {} frames, and no table that shares them out",
       input.path, f.all.size(), frames);
}

// A stream's own words about its picture.
struct StreamSize {
  uint32_t width = 0, height = 0, bits = 0, colors = 0;
};

// The position of the next marker behind the entropy-coded bytes of a scan.
size_t endOfScan(std::span<const std::byte> code, size_t at) {
  for (; at + 1 < code.size(); ++at) {
    const uint32_t next = bigAt(code, at + 1, 1);
    // 0 stands for a byte of data, or another bit-stuffed one of JPEG-LS; D0 to D7 are restarts.
    if (code[at] == std::byte{0xFF} && next >= 0x80 && (next < 0xD0 || next > 0xD7)) break;
  }
  return at;
}

// From the one start of a frame (SOF) of JPEG or JPEG-LS. nullopt: none or several, or of a process
// that DICOM does not use: decoders do not all stand that.
std::optional<StreamSize> jpegSize(std::span<const std::byte> code, bool is_ls) {
  constexpr uint32_t kBaseline = 0xFFC0, kExtended = 0xFFC1, kLossless = 0xFFC3, kLs = 0xFFF7,
                     kScan = 0xFFDA, kEnd = 0xFFD9, kTables = 0xFFC4;
  if (code.size() < 4 || bigAt(code, 0, 2) != 0xFFD8) return std::nullopt;
  std::optional<StreamSize> size;
  for (size_t at = 2; at + 4 <= code.size();) {
    const uint32_t marker = bigAt(code, at, 2);
    if (marker == 0xFFFF) {  // padding
      ++at;
      continue;
    }
    if (marker == kEnd) break;
    if (marker < 0xFFC0) return std::nullopt;
    const size_t length = bigAt(code, at + 2, 2);
    if (length < 2) return std::nullopt;
    const bool is_start =
        is_ls ? marker == kLs : marker == kBaseline || marker == kExtended || marker == kLossless;
    if (is_start) {
      if (size || length < 8 || at + 10 > code.size()) return std::nullopt;
      size = StreamSize{.width = bigAt(code, at + 7, 2),
                        .height = bigAt(code, at + 5, 2),
                        .bits = bigAt(code, at + 4, 1),
                        .colors = bigAt(code, at + 9, 1)};
    } else if ((marker >= 0xFFC0 && marker <= 0xFFCF && marker != kTables) || marker == kLs) {
      return std::nullopt;
    }
    at += 2 + length;
    if (marker == kScan) {
      if (!size) return std::nullopt;
      at = endOfScan(code, at);
    }
  }
  return size;
}

// From the marker SIZ behind the start of a codestream.
std::optional<StreamSize> jpeg2000Size(std::span<const std::byte> code) {
  constexpr size_t kHeadBytes = 45;
  constexpr uint64_t kMostTiles = 4096;
  if (code.size() < kHeadBytes || bigAt(code, 0, 4) != 0xFF4FFF51) return std::nullopt;
  const uint32_t x1 = bigAt(code, 8, 4), y1 = bigAt(code, 12, 4), x0 = bigAt(code, 16, 4),
                 y0 = bigAt(code, 20, 4), tile_x = bigAt(code, 24, 4), tile_y = bigAt(code, 28, 4);
  if (x1 <= x0 || y1 <= y0 || tile_x == 0 || tile_y == 0) return std::nullopt;
  const uint64_t tiles = (uint64_t{x1} / tile_x + 1) * (uint64_t{y1} / tile_y + 1);
  // A picture's components have steps of their own.
  if (tiles > kMostTiles || bigAt(code, 43, 1) != 1 || bigAt(code, 44, 1) != 1) return std::nullopt;
  return StreamSize{.width = x1 - x0,
                    .height = y1 - y0,
                    .bits = (bigAt(code, 42, 1) & 0x7F) + 1,
                    .colors = bigAt(code, 40, 2)};
}

}  // namespace

std::vector<DicomPlace> dicomPlaces(const DicomInput& input, const DicomHeader& header) {
  if (header.coding == DicomCoding::kPlain) return plainPlaces(input, header);
  std::vector<DicomPlace> places = fragmentPlaces(input, header);
  const uint64_t most = mostCodeBytes(header.frameBytes());
  for (const DicomPlace& place : places)
    if (place.end - place.begin > most)
      fail("{}: damaged DICOM file: a frame of {} bytes is compressed to {}", input.path,
           header.frameBytes(), place.end - place.begin);
  return places;
}

std::vector<std::byte> readDicomCode(const DicomInput& input, const DicomPlace& place) {
  std::vector<std::byte> code;
  DicomElements items(input, place.begin, {});
  while (const auto item = items.next(place.end)) {
    const size_t had = code.size();
    const uint64_t length = std::min<uint64_t>(item->length, place.end - item->at);
    // A frame may lie in several fragments, which are joined.
    code.resize(had + length);
    input.readSome(item->at, std::span(code).subspan(had));
    items.skip(*item);
  }
  return code;
}

void decodeDicomRuns(const std::string& path, std::span<const std::byte> code,
                     const DicomHeader& header, std::span<std::byte> pixels) {
  constexpr size_t kHeadBytes = 64, kMostSegments = 15;
  const auto sample_bytes = static_cast<size_t>(header.bits_allocated / 8);
  const auto segments = sample_bytes * static_cast<size_t>(header.samples);
  const auto plane = static_cast<size_t>(header.columns * header.rows);
  // The header of run lengths: the number of segments and the offset of each, in 64 bytes (PS3.5,
  // G.5).
  if (code.size() < kHeadBytes || segments > kMostSegments || littleAt(code, 0) != segments)
    fail("{}: damaged DICOM file: run lengths in {} segments, expected {}", path,
         code.size() < kHeadBytes ? 0 : littleAt(code, 0), segments);
  for (size_t segment = 0; segment < segments; ++segment) {
    // Bytes of a sample, the most significant first; each segment has the byte of all pixels.
    const size_t color = segment / sample_bytes, place = segment % sample_bytes;
    const size_t byte =
        std::endian::native == std::endian::little ? sample_bytes - 1 - place : place;
    std::byte* const to = pixels.data() + color * plane * sample_bytes + byte;
    size_t at = littleAt(code, 4 + 4 * segment), done = 0;
    const size_t end = segment + 1 < segments ? littleAt(code, 8 + 4 * segment) : code.size();
    if (at < kHeadBytes || end > code.size() || at > end)
      fail("{}: damaged DICOM file: a segment of run lengths from {} to {} of {} bytes", path, at,
           end, code.size());
    while (done < plane && at < end) {
      const auto length = std::to_integer<size_t>(code[at++]);
      // 128 stands for nothing (PS3.5, G.3.2).
      if (length == 128) continue;
      const bool is_run = length > 128;
      const size_t count = is_run ? 257 - length : length + 1;
      const size_t taken = is_run ? 1 : count;
      // A damaged run may not write behind the pixels.
      if (count > plane - done || taken > end - at) break;
      for (size_t i = 0; i < count; ++i) to[(done + i) * sample_bytes] = code[is_run ? at : at + i];
      at += taken;
      done += count;
    }
    if (done < plane)
      fail("{}: damaged DICOM file: run lengths of {} pixels, expected {}", path, done, plane);
  }
}

int64_t checkedStreamBits(const std::string& path, std::span<const std::byte> code,
                          const DicomHeader& header) {
  const auto size = header.coding == DicomCoding::kJpeg2000
                        ? jpeg2000Size(code)
                        : jpegSize(code, header.coding == DicomCoding::kJpegLs);
  if (!size)
    fail("{}: damaged DICOM file: a frame is no {} stream", path,
         header.coding == DicomCoding::kJpeg2000 ? "JPEG 2000" : "JPEG");
  // Checked before the decoder runs, which is given the sizes of the header.
  if (size->width != header.columns || size->height != header.rows || size->colors != 1 ||
      size->bits < 1 || size->bits > header.bits_allocated)
    fail(
        "{}: damaged DICOM file: a compressed frame is {} x {} pixels of {} x {} bits, expected {} "
        "x "
        "{} of up to {}",
        path, size->width, size->height, size->colors, size->bits, header.columns, header.rows,
        header.bits_allocated);
  return size->bits;
}

}  // namespace sluice
