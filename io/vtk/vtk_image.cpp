#include "io/vtk/vtk_image.h"

#include <algorithm>
#include <array>
#include <utility>

#include "io/headers/volume_description.h"
#include "src/base/error.h"

namespace sluice {

std::optional<VoxelType> vtkVoxelType(const std::string& type) {
  constexpr std::pair<const char*, VoxelType> kTypes[] = {{"UInt8", VoxelType::kU8},
                                                          {"unsigned_char", VoxelType::kU8},
                                                          {"Int8", VoxelType::kI8},
                                                          {"char", VoxelType::kI8},
                                                          {"signed_char", VoxelType::kI8},
                                                          {"UInt16", VoxelType::kU16},
                                                          {"unsigned_short", VoxelType::kU16},
                                                          {"Int16", VoxelType::kI16},
                                                          {"short", VoxelType::kI16},
                                                          {"UInt32", VoxelType::kU32},
                                                          {"unsigned_int", VoxelType::kU32},
                                                          {"Int32", VoxelType::kI32},
                                                          {"int", VoxelType::kI32},
                                                          {"Float32", VoxelType::kF32},
                                                          {"float", VoxelType::kF32},
                                                          {"Float64", VoxelType::kF64},
                                                          {"double", VoxelType::kF64}};
  for (const auto& [name, voxel_type] : kTypes)
    if (type == name) return voxel_type;
  return std::nullopt;
}

VolumeLayout vtkLayout(const VtkImage& image, bool of_cells, const std::string& path) {
  constexpr int64_t kMostIndex = int64_t{1} << 40;
  VolumeLayout layout;
  std::vector<Vec3d> steps;
  Vec3d first;  // index of the first voxel
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    const int64_t lo = image.extent[2 * axis], hi = image.extent[2 * axis + 1];
    // Differences and dims of larger indices could overflow.
    if (hi < lo || lo < -kMostIndex || hi > kMostIndex)
      fail("{}: expected an extent of one point or more along each axis, found {} to {} along {}",
           path, lo, hi, "xyz"[a]);
    // A flat image has one layer of cells, in the plane of its points.
    const bool is_between = of_cells && hi > lo;
    layout.dims[a] = hi - lo + (is_between ? 0 : 1);
    first[a] = static_cast<double>(lo) + (is_between ? 0.5 : 0);
    const auto& d = image.direction;
    steps.push_back(Vec3d{d[axis], d[3 + axis], d[6 + axis]} * image.spacing[a]);
  }
  setSteps(path, steps, layout);
  const std::array<double, 3> spacing{image.spacing.x, image.spacing.y, image.spacing.z};
  if (const std::string note = negativeSpacingNote(path, spacing); !note.empty())
    layout.notes.push_back(note);
  setOrigin(path, image.origin + steps[0] * first.x + steps[1] * first.y + steps[2] * first.z,
            layout);
  return layout;
}

bool isVti(std::string_view head) {
  const size_t at = head.find("<VTKFile");
  return at != std::string_view::npos && head.find('\0') > at;
}

bool isLegacyVtk(std::string_view head) {
  return head.starts_with("# vtk DataFile Version");
}

}  // namespace sluice
