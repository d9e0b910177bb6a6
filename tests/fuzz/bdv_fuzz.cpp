#include <algorithm>
#include <cstring>

#include "io/hdf5/bdv_xml.h"
#include "src/base/error.h"
#include "tests/fuzz/description_checks.h"

// A BigDataViewer .xml.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const sluice::ByteInput input = [&](uint64_t offset, std::span<std::byte> out) {
    const size_t at = std::min<uint64_t>(offset, size), count = std::min(out.size(), size - at);
    if (count > 0) std::memcpy(out.data(), data + at, count);
    return count;
  };
  sluice::checkParser([&] {
    const sluice::BdvImage image = sluice::parseBdvXml(input, "v.xml");
    SLUICE_CHECK(!image.setups.empty() && !image.times.empty() && !image.data.empty());
    return sluice::VolumeDescription{.layout = {.dims = {1, 1, 1}}};
  });
  return 0;
}
