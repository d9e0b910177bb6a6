// What lies between the program and its OpenVDB module.
//
// OpenVDB's library has 60 000 symbols to bind, which takes a third of the time of a command that
// reads no OpenVDB file. So all that includes its headers (vdb_module.cpp) is a library apart,
// sluice_openvdb.so, opened when the first .vdb is: it lies beside the program or, once installed,
// in ../lib/sluice. The program checks the file first (vdb_check.h); the module brings a copy of
// src/base of its own, and what it throws is an Error there and here.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "io/vdb_check.h"
#include "io/vdb_header.h"
#include "src/base/volume_source.h"

namespace sluice {

// One grid of a checked file.
struct VdbOpening {
  std::filesystem::path path;
  VdbGridInfo info;
  VdbTreeOnDisk tree;
  std::string identity;
};

// The one function of the module: as openVdb() of vdb_source.h, into `source`.
using OpenVdbGrid = void(const VdbOpening& opening, std::unique_ptr<VolumeSource>& source);
inline constexpr const char* kOpenVdbGrid = "sluiceOpenVdbGrid";

}  // namespace sluice
