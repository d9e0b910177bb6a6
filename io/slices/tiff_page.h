// What a TIFF's table says of one page, and the voxels that it is read as. Pure functions of what
// libtiff has read.
#pragma once

#include <tiffio.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "src/base/voxel_type.h"

namespace sluice {

// What is stored of one page.
struct TiffPage {
  uint64_t directory = 0;  // where its table lies in the file
  uint32_t width = 0, height = 0;
  uint16_t bits = 1, samples = 1, sample_format = SAMPLEFORMAT_UINT;
  uint16_t photometric = PHOTOMETRIC_MINISBLACK, compression = COMPRESSION_NONE;
  uint16_t planar = PLANARCONFIG_CONTIG, orientation = ORIENTATION_TOPLEFT;
  uint16_t predictor = PREDICTOR_NONE, fill_order = FILLORDER_MSB2LSB;
  bool is_tiled = false;
  uint64_t moved_bytes = 0;  // its voxels lie this far behind those that its table names

  bool hasColor() const {
    return photometric == PHOTOMETRIC_RGB || photometric == PHOTOMETRIC_YCBCR;
  }
  // Of the kind that DeflateRows decodes: all that zlib compresses, but for bits in reverse.
  bool isDeflate() const {
    return (compression == COMPRESSION_ADOBE_DEFLATE || compression == COMPRESSION_DEFLATE) &&
           fill_order == FILLORDER_MSB2LSB && predictor >= PREDICTOR_NONE &&
           predictor <= PREDICTOR_FLOATINGPOINT;
  }
  size_t pixelBytes() const { return size_t{samples} * bits / 8; }
};

// Of the page at which `tiff` stands; `otherwise` where the file does not say and has no default.
template <class T>
T tiffField(TIFF* tiff, uint32_t tag, T otherwise) {
  T value{};
  return TIFFGetFieldDefaulted(tiff, tag, &value) == 1 ? value : otherwise;
}
TiffPage tiffPageOf(TIFF* tiff);

// Throws Error, which names the file at `path`, for pixels that are no scalars of a known type.
VoxelType voxelTypeOf(const TiffPage& page, const std::string& path);

}  // namespace sluice
