#include "io/slices/slice_picture.h"

#include <array>
#include <cstring>
#include <string_view>

#include "io/files/file.h"
#include "io/slices/png_slice.h"
#include "io/slices/tiff/tiff_slice.h"
#include "src/base/error.h"

namespace sluice {
namespace {

enum class Kind { kPng, kTiff, kOther };

Kind kindOf(const std::filesystem::path& path) {
  std::array<std::byte, 4> first{};
  File file(path);
  file.readSome(0, first);
  const std::string_view magic(reinterpret_cast<const char*>(first.data()), first.size());
  using namespace std::string_view_literals;
  if (magic == "\x89PNG"sv) return Kind::kPng;
  // 42 is TIFF, 43 BigTIFF, each in either byte order.
  for (const auto tiff : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (magic == tiff) return Kind::kTiff;
  }
  return Kind::kOther;
}

}  // namespace

bool isSlicePicture(const std::filesystem::path& path) {
  return kindOf(path) != Kind::kOther;
}

std::unique_ptr<SlicePicture> openSlicePicture(const std::filesystem::path& path,
                                               const std::shared_ptr<const PictureTables>& known) {
  switch (kindOf(path)) {
    case Kind::kPng:
      return openPng(path);
    case Kind::kTiff:
      return openTiff(path, known);
    case Kind::kOther:
      break;
  }
  fail("{}: expected a PNG or TIFF picture, found neither's first bytes", path.string());
}

}  // namespace sluice
