#include "io/meta_image.h"

#include <utility>

#include "io/described_volume.h"
#include "io/meta_image_header.h"

namespace sluice {

std::unique_ptr<VolumeSource> openMetaImage(const std::filesystem::path& path) {
  auto file = std::make_shared<File>(path);
  const std::string text = readHead(*file, metaImageHeaderComplete);
  const VolumeDescription description = parseMetaImageHeader(text, file->path());
  return openDescribed(std::move(file), description);
}

}  // namespace sluice
