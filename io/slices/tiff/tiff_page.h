// The properties of a page from a TIFF's table, and the voxels that it is read as. Pure functions
// of what libtiff has read.
#pragma once

#include <tiffio.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/base/values/voxel_type.h"

namespace sluice {

// How a page is stored.
struct TiffPage {
  uint64_t directory = 0;  // offset of its table in the file
  uint32_t width = 0, height = 0, depth = 1;
  uint16_t bits = 1, samples = 1, sample_format = SAMPLEFORMAT_UINT;
  uint16_t photometric = PHOTOMETRIC_MINISBLACK, compression = COMPRESSION_NONE;
  uint16_t planar = PLANARCONFIG_CONTIG, orientation = ORIENTATION_TOPLEFT;
  uint16_t predictor = PREDICTOR_NONE, fill_order = FILLORDER_MSB2LSB;
  bool is_tiled = false;
  // The number that stands for no value (GDAL_NODATA).
  std::optional<double> no_data = {};
  // value = stored * value_scale + value_offset, by the metadata of GDAL.
  double value_scale = 1, value_offset = 0;
  uint64_t moved_bytes = 0;  // its voxels lie this far behind those that its table names

  bool hasColor() const {
    return photometric == PHOTOMETRIC_RGB || photometric == PHOTOMETRIC_YCBCR;
  }
  // Whether DeflateRows decodes the page: any zlib stream, unless its bits are reversed.
  bool isDeflate() const {
    return (compression == COMPRESSION_ADOBE_DEFLATE || compression == COMPRESSION_DEFLATE) &&
           fill_order == FILLORDER_MSB2LSB && predictor >= PREDICTOR_NONE &&
           predictor <= PREDICTOR_FLOATINGPOINT;
  }
  // Pixels of these numbers have no value.
  std::vector<double> missingValues() const {
    return no_data ? std::vector<double>{*no_data} : std::vector<double>();
  }
  size_t pixelBytes() const { return size_t{samples} * bits / 8; }
};

// A field of the page at which `tiff` stands; `otherwise` if it is missing and has no default.
template <class T>
T tiffField(TIFF* tiff, uint32_t tag, T otherwise) {
  T value{};
  return TIFFGetFieldDefaulted(tiff, tag, &value) == 1 ? value : otherwise;
}
TiffPage tiffPageOf(TIFF* tiff);

// The offsets of the tables of a page's own reduced images (SubIFDs), as many as there are up
// to 32.
std::vector<uint64_t> reducedDirectoriesOf(TIFF* tiff);

// Throws Error, which names the file at `path`, for pixels that are no scalars of a known type.
VoxelType voxelTypeOf(const TiffPage& page, const std::string& path);

}  // namespace sluice
