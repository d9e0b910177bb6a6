// Hdf5Input: an HDF5 file, and its data sets as ChunkedArrays.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/file.h"
#include "io/hdf5/hdf5_module.h"
#include "io/zarr/reading/chunked_array.h"

namespace sluice {

// Whether the first bytes are an HDF5 file's.
bool isHdf5(std::string_view head);

struct Hdf5Input {
  std::shared_ptr<File>
      file;  // whose status is compared, and from which voxels in one piece are read
  std::shared_ptr<Hdf5File> inside;  // the same through the module
};

// Throws Error: no such file, no HDF5, the module is missing.
Hdf5Input openHdf5Input(const std::string& path);

// Null: there is none of that name.
const Hdf5Attribute* find(const std::vector<Hdf5Attribute>& attributes, std::string_view name);

// A description as a Zarr array; sets of one and two axes get more in front. Throws Error, which
// starts with `name`: too large, empty, filters that nothing here can undo.
ZarrArray hdf5ArrayOf(const Hdf5Description& description, const std::string& name);

// The chunks of a data set. One in no chunks, or with filters that the library alone can undo, is
// read through the library.
std::unique_ptr<ChunkedArray> hdf5Chunks(const Hdf5Input& input, std::unique_ptr<Hdf5Set> set,
                                         ZarrArray array, const std::string& name);

}  // namespace sluice
