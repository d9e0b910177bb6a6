#include "io/headers/nifti/nifti.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "io/files/inflater.h"
#include "io/headers/described_volume.h"
#include "io/headers/nifti/nifti_header.h"
#include "src/base/error.h"
#include "src/base/sources/forwarding_source.h"

namespace sluice {
namespace {

class TimedVolume final : public ForwardingSource {
 public:
  TimedVolume(std::unique_ptr<VolumeSource> source, TimeAxis times)
      : ForwardingSource(std::move(source)), times_(std::move(times)) {}
  std::optional<TimeAxis> times() const override { return times_; }

 private:
  const TimeAxis times_;
};

bool isGzip(File& file) {
  std::array<std::byte, 2> magic{};
  file.readSome(0, magic);
  return magic[0] == std::byte{0x1f} && magic[1] == std::byte{0x8b};
}

// `path` with the last occurrence of `from` in the file name replaced; empty when there is none.
std::string withEnding(const std::string& path, std::string_view from, std::string_view to) {
  for (const std::string_view tail : {"", ".gz"}) {
    const std::string ending = std::string(from) + std::string(tail);
    if (path.ends_with(ending))
      return path.substr(0, path.size() - ending.size()) + std::string(to) + std::string(tail);
  }
  return "";
}

// The voxels of a pair lie in the header's folder, gzipped or not.
std::string imageBeside(const std::string& header) {
  const std::string same = withEnding(header, ".hdr", ".img");
  if (same.empty())
    fail("{}: the header of a pair of files (magic ni1 or ni2) needs a name that ends in .hdr",
         header);
  const std::string plain = same.ends_with(".gz") ? same.substr(0, same.size() - 3) : same;
  std::error_code ignored;  // a name that leads nowhere, such as a circle of links, has no voxels
  for (const std::string& candidate : {same, plain, plain + ".gz"})
    if (std::filesystem::exists(candidate, ignored)) return candidate;
  fail("{}: {} with its voxels is missing", header, same);
}

}  // namespace

std::unique_ptr<VolumeSource> openNifti(const std::filesystem::path& path,
                                        const DecodeOptions& decode) {
  // Either file of a pair may be named.
  const std::string header_of_image = withEnding(path.string(), ".img", ".hdr");
  auto file = std::make_shared<File>(header_of_image.empty() ? path.string() : header_of_image);
  std::array<std::byte, kNiftiHeaderBytes> bytes{};
  const bool header_gzipped = isGzip(*file);
  const size_t got = header_gzipped ? Inflater(file, 0).read(bytes) : file->readSome(0, bytes);
  NiftiHeader header = parseNiftiHeader(std::span(bytes).first(got), file->path());
  bool gzipped = header_gzipped;
  if (header.pair) {
    const std::filesystem::path image = imageBeside(file->path());
    header.description.files.names = {image.filename().string()};
    File image_file(image);
    gzipped = isGzip(image_file);
  }
  if (gzipped) header.description.encoding = Encoding::kDeflate;
  auto source = openDescribed(std::move(file), header.description, "", decode);
  if (!header.times) return source;
  return std::make_unique<TimedVolume>(std::move(source), *header.times);
}

}  // namespace sluice
