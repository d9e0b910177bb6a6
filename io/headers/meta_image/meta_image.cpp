#include "io/headers/meta_image/meta_image.h"

#include <utility>

#include "io/headers/described_volume.h"
#include "io/headers/meta_image/meta_image_header.h"

namespace sluice {

std::unique_ptr<VolumeSource> openMetaImage(const std::filesystem::path& path,
                                            const DecodeOptions& decode) {
  auto file = std::make_shared<File>(path);
  const std::string text = readHead(*file, metaImageHeaderComplete);
  const VolumeDescription description = parseMetaImageHeader(text, file->path());
  return openDescribed(std::move(file), description, "", decode);
}

}  // namespace sluice
