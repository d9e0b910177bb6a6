#include "io/nrrd.h"

#include <utility>

#include "io/described_volume.h"
#include "io/nrrd_header.h"

namespace sluice {

std::unique_ptr<VolumeSource> openNrrd(const std::filesystem::path& path) {
  auto file = std::make_shared<File>(path);
  const std::string text = readHead(*file, [](std::string_view head) {
    return !head.starts_with("NRRD") || nrrdHeaderBytes(head) != std::string_view::npos;
  });
  const VolumeDescription description = parseNrrdHeader(text, file->path());
  return openDescribed(std::move(file), description);
}

}  // namespace sluice
