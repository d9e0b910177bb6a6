#include <algorithm>

#include "io/zarr/n5/n5_attributes.h"
#include "io/zarr/n5/n5_block.h"
#include "src/base/error.h"
#include "tests/fuzz/description_checks.h"

// The attributes.json of a data set, an empty line, those of a group, an empty line, a block.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  const auto next = [&rest] {
    const size_t end = std::min(rest.find("\n\n"), rest.size());
    const std::string_view part = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 2, rest.size()));
    return part;
  };
  const std::string_view set = next(), group = next();
  sluice::checkParser([&] {
    const sluice::ZarrArray array = sluice::parseN5Array(set, "v/attributes.json");
    const int64_t last = array.chunkCount() - 1;
    SLUICE_CHECK(!array.fileName(last).empty());
    SLUICE_CHECK_LE(array.chunkBytes(), sluice::kMostChunkBytes);
    const sluice::ZarrImage image =
        sluice::n5Image(sluice::parseN5Place(group, "v/attributes.json"),
                        {sluice::parseN5Place(set, "v/attributes.json")}, array.axes(), "v");
    sluice::VolumeDescription description;
    description.layout = viewZarr(array, image, size % 2 == 1, "v/attributes.json").layout;
    const sluice::N5Block block =
        sluice::parseN5Block(array, last, std::as_bytes(std::span(rest)), "v/0");
    SLUICE_CHECK_LE(block.bytes, array.chunkBytes());
    return description;
  });
  return 0;
}
