// The interface between the program and its OpenVDB module.
//
// OpenVDB's library has 60 000 symbols to bind, which takes a third of the time of a command that
// reads no OpenVDB file. So all that includes its headers (vdb_module.cpp) is a library apart,
// sluice_openvdb.so, opened when the first .vdb is (src/base/files/program_module.h says where
// from). The program checks the file first (vdb_check.h); the module brings a copy of src/base of
// its own, and an exception from it is an Error there and here.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/files/byte_store.h"
#include "io/vdb/vdb_check.h"
#include "io/vdb/vdb_header.h"
#include "src/base/sources/volume_source.h"

namespace sluice {

// A grid of a checked file.
struct VdbOpening {
  std::string path;
  // Read at positions, each time checked to be the file that was opened: nothing is mapped, so that
  // a file that is cut or overwritten meanwhile is an Error.
  std::shared_ptr<ByteStore> file;
  VdbGridInfo info;
  VdbTreeOnDisk tree;
  std::string identity;
  std::optional<Box3> box;         // index space to deliver; unset: see vdb_source.h
  std::vector<std::string> grids;  // for the layout, as the notes are
  std::vector<std::string> notes;
};

// The one function of the module: as openVdb() of vdb_source.h, into `source`.
using OpenVdbGrid = void(const VdbOpening& opening, std::unique_ptr<VolumeSource>& source);
inline constexpr const char* kOpenVdbGrid = "sluiceOpenVdbGrid";

// A module must export this before anything is called: the version of sluice and of this interface.
// The number counts up with each change of the interface.
inline constexpr const char* kOpenVdbVersion = "sluiceOpenVdbVersion";
inline constexpr const char* kOpenVdbModuleVersion = SLUICE_VERSION " module 2";

}  // namespace sluice
