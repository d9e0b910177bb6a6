// OME-Zarr images and plain Zarr arrays, of version 2 and 3, as a VolumeSource.
//
// A folder with a .zarray or an array's zarr.json is an array; one whose .zattrs or zarr.json has
// `multiscales` is an image. Levels that sluice packed as means have their spreads
// (io/zarr/metadata/zarr_image.h). Name the folder of a level to read that one alone; its scale is
// found in the image around it. Axes, spacing and origin as io/zarr/metadata/zarr_image.h says,
// chunks as io/zarr/metadata/zarr_array.h, and what is read of them as chunked_source.h.
//
// - Chunks that sluice packed carry checksums; then a missing or changed one is an Error.
// - identity() covers .zarray, .zattrs, checksums and the array's folder, and of a store without
//   checksums the status of at most kSampledChunks chunk files, evenly spread: there may be
//   millions.
#pragma once

#include <filesystem>

#include "io/stores/chunk_store.h"
#include "io/zarr/reading/chunked_source.h"
#include "io/zarr/reading/zarr_chunk_files.h"

namespace sluice {

using ZarrOptions = ChunkedOptions;

class ZarrSource final : public ChunkedSource {
 public:
  // Throws Error: nothing in the folder that can be read, --channel without such an axis.
  explicit ZarrSource(const StorePlace& folder, const ZarrOptions& options = {});
  explicit ZarrSource(const std::filesystem::path& folder, const ZarrOptions& options = {});

  // Whether each chunk is checked as it is read.
  bool hasChecksums() const { return filesOf(*this).hasChecksums(); }
  // The chunk files of such a source, or of one of its levels.
  static ZarrChunkFiles& filesOf(ChunkedSource& source) {
    return dynamic_cast<ZarrChunkFiles&>(source.chunks());
  }
  static const ZarrChunkFiles& filesOf(const ChunkedSource& source) {
    return dynamic_cast<const ZarrChunkFiles&>(source.chunks());
  }
};

}  // namespace sluice
