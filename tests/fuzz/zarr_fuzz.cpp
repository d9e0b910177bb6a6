#include <algorithm>

#include "io/zarr/metadata/zarr_image.h"
#include "src/base/error.h"
#include "tests/fuzz/description_checks.h"

// A .zarray or zarr.json, an empty line, a .zattrs.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const size_t end = std::min(text.find("\n\n"), text.size());
  const std::string_view rest = text.substr(std::min(end + 2, text.size()));
  sluice::checkParser([&] {
    const sluice::ZarrArray array = sluice::parseZarrArray(text.substr(0, end), "v/.zarray");
    const int64_t last = array.chunkCount() - 1;
    SLUICE_CHECK_EQ(array.chunkNumber(array.chunkIndex(last)), last);
    const sluice::ZarrArray::Place place = array.placeOf(last);
    SLUICE_CHECK_LT(place.file, array.fileCount());
    SLUICE_CHECK_LT(place.chunk, array.chunksAFile());
    SLUICE_CHECK(!array.fileName(place.file).empty());
    SLUICE_CHECK_LE(array.chunkBytes(), sluice::kMostChunkBytes);
    const sluice::ZarrImage image = sluice::parseZarrImage(rest, "v/.zattrs");
    sluice::VolumeDescription description;
    description.layout = viewZarr(array, image, size % 2 == 1, "v/.zattrs").layout;
    return description;
  });
  sluice::checkParser([&] {
    sluice::parseZarrImage(text.substr(0, end), "v/zarr.json");
    return sluice::VolumeDescription{.layout = {.dims = {1, 1, 1}}};
  });
  sluice::checkParser([&] {
    sluice::parseZarrImage(rest, "v/.zattrs", "1");
    return sluice::VolumeDescription{.layout = {.dims = {1, 1, 1}}};
  });
  return 0;
}
