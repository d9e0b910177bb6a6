// The table of contents of an OpenVDB file, read by ourselves.
//
// OpenVDB trusts the sizes that a file states and reads on past its end without a word. So the
// table is read first, every size in it held against the file's: a file cut short is refused
// before OpenVDB sees it, and the grids can be listed without loading one. vdb_check.h does the
// same for a tree. Plain functions, any thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/file.h"
#include "src/base/values/vec.h"

namespace sluice {

// The classes that OpenVDB knows.
inline constexpr std::array<std::string_view, 4> kVdbGridClasses{"unknown", "level set",
                                                                 "fog volume", "staggered"};

struct VdbGridInfo {
  std::string name;        // "density"; "density[1]" if several grids share the name
  std::string value_type;  // "float", "double", "int32", "int64", "bool", "mask", "vec3s", ...
  std::string tree_shape;  // "5_4_3": the sizes of the nodes, as powers of two
  std::string grid_class;  // "fog volume", "level set", ...; empty if the file does not tell
  bool saved_as_half = false;
  std::string instance_of;   // the name of the grid whose tree this one shares; empty: its own
  uint32_t compression = 0;  // OpenVDB's flags
  // The box of the active voxels in index space, if the file's metadata has it; may be empty.
  std::optional<Box3> active;
  uint32_t file_version = 0, library_major = 0, library_minor = 0;
  // Offsets in the file: the transform, behind which the tree begins; the leaves' values; the end.
  uint64_t transform_at = 0, values_at = 0, end = 0;
};

// The grids in the order of the file. Throws Error when the file is not an OpenVDB file, is cut
// short, or was written in a way that keeps no such table (before 2013, or through a pipe).
std::vector<VdbGridInfo> readVdbGrids(File& file);

// The grid called `wanted`; when empty, the first one of floats or doubles, else the first of
// another scalar type (int32, int64, bool, mask). Throws Error when there is none, with the names
// and types.
VdbGridInfo chooseVdbGrid(const std::string& path, const std::vector<VdbGridInfo>& grids,
                          const std::string& wanted);

// Whether a grid can be chosen.
bool isScalar(const VdbGridInfo& grid);

// "density (float, fog volume), v (vec3s)": for messages.
std::string describe(const std::vector<VdbGridInfo>& grids);

}  // namespace sluice
