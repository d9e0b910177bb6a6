#include <algorithm>
#include <cstring>

#include "io/headers/volume_description.h"
#include "io/vtk/vtk_image.h"
#include "src/base/error.h"
#include "tests/fuzz/description_checks.h"

// A .vti or legacy .vtk file.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const sluice::ByteInput input = [&](uint64_t offset, std::span<std::byte> out) {
    const size_t at = std::min<uint64_t>(offset, size), count = std::min(out.size(), size - at);
    if (count > 0) std::memcpy(out.data(), data + at, count);
    return count;
  };
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  sluice::checkParser([&] {
    const sluice::VtkImage image = sluice::isLegacyVtk(text)
                                       ? sluice::parseLegacyVtk(input, "v.vtk")
                                       : sluice::parseVti(input, "v.vti");
    SLUICE_CHECK_LE(image.arrays.size(), sluice::kMostVtkArrays);
    sluice::VolumeDescription description;
    description.layout = vtkLayout(image, size % 2 == 1, "v");
    checkedVolumeBytes("v", description.layout);
    return description;
  });
  return 0;
}
