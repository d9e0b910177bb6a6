#include "io/headers/nrrd/nrrd.h"

#include <utility>

#include "io/headers/described_volume.h"
#include "io/headers/nrrd/nrrd_header.h"

namespace sluice {

std::unique_ptr<VolumeSource> openNrrd(const std::filesystem::path& path,
                                       const DecodeOptions& decode) {
  auto file = std::make_shared<File>(path);
  const std::string text = readHead(*file, [](std::string_view head) {
    return !head.starts_with("NRRD") || nrrdHeaderBytes(head) != std::string_view::npos;
  });
  const VolumeDescription description = parseNrrdHeader(text, file->path());
  return openDescribed(std::move(file), description, "", decode);
}

}  // namespace sluice
