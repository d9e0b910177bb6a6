#include "io/named_input.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "io/files/file.h"
#include "io/hdf5/hdf5_input.h"
#include "io/stores/folder_store.h"
#include "io/stores/zip_store.h"
#include "io/synth/synth_source.h"
#include "io/web/address.h"
#include "io/web/web_place.h"
#include "src/base/error.h"

namespace sluice {

namespace fs = std::filesystem;

namespace {

// gs://..., file:///..., HTTP://...: fails, unless a file has this name.
void refuseOtherScheme(const std::string& name) {
  const size_t end = name.find("://");
  if (end == 0 || end == name.npos) return;
  const auto may_be_scheme = [](unsigned char c) {
    return std::isalnum(c) || c == '+' || c == '-';
  };
  if (!std::all_of(name.begin(), name.begin() + static_cast<std::ptrdiff_t>(end), may_be_scheme))
    return;
  std::error_code none;
  if (fs::exists(name.substr(0, end + 1), none)) return;
  fail("{}: expected an address that begins with http://, https:// or s3://, found {}",
       withoutSecrets(name), name.substr(0, end + 3));
}

}  // namespace

InputPath splitInputPath(const std::string& name) {
  std::error_code missing;
  const size_t end = name.find(":/");
  if (end == name.npos || fs::exists(name, missing)) return {name, ""};
  return {name.substr(0, end), name.substr(end + 1)};
}

NamedInput lookAt(const std::string& name, const OpenOptions& options) {
  NamedInput input;
  input.name = name;
  if (isSynthSpec(name)) return input;
  if (isAddress(name)) {
    input.store = webPlace(name, options.web, options.stop);
    return input;
  }
  refuseOtherScheme(name);
  InputPath path = splitInputPath(name);
  input.file = path.file;
  input.inside = std::move(path.inside);
  std::error_code missing;
  input.is_folder = fs::is_directory(input.file, missing);
  if (input.is_folder) {
    if (!input.inside.empty())
      fail(
          "{}: expected an HDF5 or zip file in front of ':{}', found a folder; name what is in it, "
          "'{}{}'",
          input.file.string(), input.inside, input.file.string(), input.inside);
    input.store = folderPlace(input.file);
    return input;
  }
  // No format needs more bytes to be recognized.
  std::array<std::byte, 4096> bytes{};
  File file(input.file);
  input.head.assign(reinterpret_cast<const char*>(bytes.data()), file.readSome(0, bytes));
  if (isZip(input.head))
    input.store = zipPlace(input.file, input.inside);
  else if (!input.inside.empty() && !isHdf5(input.head))
    fail("{}: expected an HDF5 or zip file in front of ':{}', found another kind",
         input.file.string(), input.inside);
  return input;
}

}  // namespace sluice
