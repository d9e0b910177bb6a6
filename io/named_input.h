// NamedInput: a user's name for a volume, with the file, folder or store that lies there.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "io/open_options.h"
#include "io/stores/chunk_store.h"

namespace sluice {

// The parts of a name such as "scan.h5:/images/0".
struct InputPath {
  std::string file;
  std::string inside;  // from the slash on; empty: the name is that of a file
};

// A file may have ":/" in its own name. Requires: `name` is no address.
InputPath splitInputPath(const std::string& name);

struct NamedInput {
  std::string name;  // as it was given
  // A file or folder of this machine; empty: an address, a synthetic volume.
  std::filesystem::path file;
  bool is_folder = false;
  std::optional<StorePlace> store;  // a folder, an address, or what is in a zip file
  std::string inside;  // the path of a data set inside the file, after its name and ':'
  std::string head;    // the first bytes of a file, at most 4096
};

// Throws Error: there is no such file, or its first bytes cannot be read; no address.
NamedInput lookAt(const std::string& name, const OpenOptions& options);

}  // namespace sluice
