// VtkImage: the arrays of a VTK image and their place, from the header of a .vti or a legacy .vtk
// file.
//
// Pure functions but for what they are given to read from, so that the parsers can be fuzzed.
// Sources: VTK's file formats ("VTK XML formats", version 0.1 to 2.2; legacy 1.0 to 5.1).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/xml_scanner.h"
#include "src/base/sources/volume_source.h"
#include "src/base/values/vec.h"
#include "src/base/values/voxel_type.h"

namespace sluice {

enum class VtkForm { kText, kBase64, kRaw };
enum class VtkCodec { kNone, kZlib, kLz4, kXz };

// One array of numbers, and where they lie in the file.
struct VtkArray {
  std::string name;
  std::string type;  // as the file has it, see vtkVoxelType()
  int64_t components = 1;
  bool is_of_cells = false;  // a number for each cell, not for each point
  VtkForm form = VtkForm::kRaw;
  uint64_t offset = 0;  // of its first byte, or its block header's
  uint64_t end = 0;     // of text: where it ends at the latest
};

// The type of COLOR_SCALARS in a text file, which are written as shares of 255.
inline constexpr std::string_view kVtkTextColors = "colours as text";

// More are an Error.
inline constexpr size_t kMostVtkArrays = 4096;

struct VtkImage {
  std::array<int64_t, 6> extent{};  // of points: first and last index along x, y and z
  Vec3d origin, spacing{1, 1, 1};
  std::array<double, 9> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};  // columns are the axes
  std::vector<VtkArray> arrays;
  std::string active_point, active_cell;  // names of the arrays to be shown; may be empty
  std::endian byte_order = std::endian::little;
  // Of .vti: a header stands before the bytes of each array that is not text.
  bool has_block_headers = false;
  size_t header_bytes = 4;  // of each of its numbers
  VtkCodec codec = VtkCodec::kNone;
};

// The type of voxels; nullopt: one that is not read, such as 64-bit integers and bits.
std::optional<VoxelType> vtkVoxelType(const std::string& type);

// The layout of an image's points or cells, without type and name. Throws Error, which starts with
// `path`: extents or a place that none can have.
VolumeLayout vtkLayout(const VtkImage& image, bool of_cells, const std::string& path);

// Throws Error, which starts with `path`: no .vti of one piece that can be read.
VtkImage parseVti(const ByteInput& input, const std::string& path);

// Whether the first bytes are a legacy file's, or a .vti's.
bool isLegacyVtk(std::string_view head);
bool isVti(std::string_view head);

// Throws Error, which starts with `path`: no legacy file of structured points that can be read.
VtkImage parseLegacyVtk(const ByteInput& input, const std::string& path);

}  // namespace sluice
