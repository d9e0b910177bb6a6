// The table of contents of an OpenVDB file, read by ourselves.
//
// OpenVDB trusts the sizes that a file states and reads on past its end without a word. So the
// table is read first, every size in it held against the file's: a file cut short is refused
// before OpenVDB sees it, and the grids can be listed without loading one. The trees themselves
// are OpenVDB's business. Plain functions, any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace sluice {

struct VdbGridInfo {
  std::string name;        // "density"; "density[1]" where several grids share the name
  std::string value_type;  // "float", "double", "int32", "int64", "bool", "mask", "vec3s", ...
  std::string grid_class;  // "fog volume", "level set", ...; empty where the file does not say
  bool saved_as_half = false;
  bool is_instance = false;     // shares the tree of another grid
  uint64_t topology_bytes = 0;  // metadata, transform and the tree without its leaves' values
  uint64_t value_bytes = 0;     // the leaves' values, compressed
};

// The grids in the order of the file. Throws Error when the file is not an OpenVDB file, is cut
// short, or was written in a way that keeps no table (before OpenVDB 1.0, or through a pipe).
std::vector<VdbGridInfo> readVdbGrids(const std::filesystem::path& path);

// "density (float, fog volume), v (vec3s)": for messages.
std::string describe(const std::vector<VdbGridInfo>& grids);

}  // namespace sluice
