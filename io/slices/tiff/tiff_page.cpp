#include "io/slices/tiff/tiff_page.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <string_view>

#include "io/files/xml_scanner.h"
#include "src/base/error.h"
#include "src/base/files/number_text.h"

namespace sluice {
namespace {

// A text of GDAL's, at most `longest` bytes of it; empty: none. libtiff knows the tag only as one
// that it has met. Valid until the next page.
std::string_view textOf(TIFF* tiff, uint32_t tag, size_t longest) {
  uint32_t count = 0;
  const void* text = nullptr;
  const TIFFField* const field = TIFFFindField(tiff, tag, TIFF_ASCII);
  if (field == nullptr || TIFFFieldPassCount(field) == 0 ||
      TIFFGetField(tiff, tag, &count, &text) != 1 || text == nullptr)
    return {};
  const std::string_view all(static_cast<const char*>(text), std::min<size_t>(count, longest));
  return all.substr(0, all.find('\0'));
}

// GDAL_NODATA as a number.
std::optional<double> noDataOf(TIFF* tiff) {
  constexpr uint32_t kTag = 42113;
  constexpr size_t kLongest = 40;
  const std::string_view word = textOf(tiff, kTag, kLongest);
  return numberIn<double>(word.substr(0, word.find(' ')));
}

// The factor and the offset of the first sample in GDAL_METADATA:
// <GDALMetadata><Item name="SCALE" sample="0" role="scale">0.5</Item>...
void readScale(TIFF* tiff, TiffPage& page) {
  constexpr uint32_t kTag = 42112;
  constexpr size_t kLongest = 1 << 20;
  const std::string_view text = textOf(tiff, kTag, kLongest);
  if (text.find("<GDALMetadata") == text.npos) return;
  double* number = nullptr;
  std::string digits;
  XmlHandlers handlers;
  handlers.begin = [&](const XmlTag& tag) {
    const std::string_view role = tag.find("role").value_or("");
    number = nullptr;
    digits.clear();
    if (tag.name == "Item" && tag.find("sample").value_or("0") == "0")
      number = role == "scale"    ? &page.value_scale
               : role == "offset" ? &page.value_offset
                                  : nullptr;
    return true;
  };
  handlers.text = [&](std::string_view part) {
    if (number != nullptr) digits += part;
  };
  handlers.end = [&](std::string_view, uint64_t) {
    if (number != nullptr) *number = numberIn<double>(digits).value_or(*number);
    number = nullptr;
  };
  try {
    scanXml(
        [&](uint64_t offset, std::span<std::byte> out) {
          const std::string_view rest = text.substr(std::min<uint64_t>(offset, text.size()));
          const size_t bytes = std::min(rest.size(), out.size());
          std::memcpy(out.data(), rest.data(), bytes);
          return bytes;
        },
        "", handlers);
  } catch (const Error&) {
    // Other programs' metadata, which need not be right for the picture to be.
    page.value_scale = 1;
    page.value_offset = 0;
  }
}

}  // namespace

TiffPage tiffPageOf(TIFF* tiff) {
  TiffPage p;
  p.directory = TIFFCurrentDirOffset(tiff);
  p.width = tiffField<uint32_t>(tiff, TIFFTAG_IMAGEWIDTH, 0);
  p.height = tiffField<uint32_t>(tiff, TIFFTAG_IMAGELENGTH, 0);
  p.depth = tiffField<uint32_t>(tiff, TIFFTAG_IMAGEDEPTH, 1);
  p.bits = tiffField<uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE, 1);
  p.samples = tiffField<uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  p.sample_format = tiffField<uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  p.photometric = tiffField<uint16_t>(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  p.compression = tiffField<uint16_t>(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  p.planar = tiffField<uint16_t>(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  p.orientation = tiffField<uint16_t>(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  // Other codecs do not know of it, and asking is an error then.
  if (p.compression == COMPRESSION_ADOBE_DEFLATE || p.compression == COMPRESSION_DEFLATE)
    p.predictor = tiffField<uint16_t>(tiff, TIFFTAG_PREDICTOR, PREDICTOR_NONE);
  p.fill_order = tiffField<uint16_t>(tiff, TIFFTAG_FILLORDER, FILLORDER_MSB2LSB);
  p.is_tiled = TIFFIsTiled(tiff) != 0;
  p.no_data = noDataOf(tiff);
  readScale(tiff, p);
  return p;
}

std::vector<uint64_t> reducedDirectoriesOf(TIFF* tiff) {
  // Sides have 32 bits, so that 32 halvings reach a pixel; a damaged count must not list more.
  constexpr uint16_t kMost = 32;
  uint16_t count = 0;
  const uint64_t* offsets = nullptr;
  if (TIFFGetField(tiff, TIFFTAG_SUBIFD, &count, &offsets) != 1 || offsets == nullptr) return {};
  return {offsets, offsets + std::min(count, kMost)};
}

VoxelType voxelTypeOf(const TiffPage& p, const std::string& path) {
  if (p.depth != 1)
    fail("{}: a page of {} planes (ImageDepth), expected pages of one plane each", path, p.depth);
  const bool is_gray =
      p.photometric == PHOTOMETRIC_MINISBLACK || p.photometric == PHOTOMETRIC_MINISWHITE;
  const bool is_unsigned =
      p.sample_format == SAMPLEFORMAT_UINT || p.sample_format == SAMPLEFORMAT_VOID;
  const bool samples_fit = p.hasColor() ? p.samples >= 3 : p.samples >= 1;
  // libtiff turns these into RGB itself (JPEGCOLORMODE_RGB in tiff_slice.cpp).
  const bool is_jpeg_color =
      p.photometric == PHOTOMETRIC_YCBCR && p.compression == COMPRESSION_JPEG && p.bits == 8;
  const bool is_side_by_side = p.planar == PLANARCONFIG_CONTIG || p.samples == 1;
  if (samples_fit && p.samples <= 16 && is_side_by_side) {
    if (p.photometric == PHOTOMETRIC_PALETTE && is_unsigned && p.bits == 8) return VoxelType::kU8;
    if (((p.photometric == PHOTOMETRIC_RGB && is_unsigned) || is_jpeg_color) && p.bits == 8)
      return VoxelType::kU8;
    if (p.photometric == PHOTOMETRIC_RGB && is_unsigned && p.bits == 16) return VoxelType::kU16;
    if (is_gray && is_unsigned && p.bits == 8) return VoxelType::kU8;
    if (is_gray && is_unsigned && p.bits == 16) return VoxelType::kU16;
    if (is_gray && is_unsigned && p.bits == 32) return VoxelType::kU32;
    if (is_gray && p.sample_format == SAMPLEFORMAT_INT && p.bits == 8) return VoxelType::kI8;
    if (is_gray && p.sample_format == SAMPLEFORMAT_INT && p.bits == 16) return VoxelType::kI16;
    if (is_gray && p.sample_format == SAMPLEFORMAT_INT && p.bits == 32) return VoxelType::kI32;
    if (is_gray && p.sample_format == SAMPLEFORMAT_IEEEFP && p.bits == 32) return VoxelType::kF32;
    if (is_gray && p.sample_format == SAMPLEFORMAT_IEEEFP && p.bits == 64) return VoxelType::kF64;
  }
  fail(
      "{}: TIFF of {} samples of {} bits (sample format {}, photometric {}, planar {}), expected "
      "grey "
      "of 8, 16 or 32 bit integers or 32 or 64 bit floats, or 8 or 16 bit palette or RGB",
      path, p.samples, p.bits, p.sample_format, p.photometric, p.planar);
}

}  // namespace sluice
