// OpenVDB grids as a VolumeSource.
//
// - Types: float and double as they are (grids saved as half are delivered as f32), int32 as i32,
//   int64 as f64 (exact up to 2^53 in magnitude, rounded beyond), bool and mask as u8 of 0 and 1.
// - Size: the box of the active voxels and tiles, and one voxel more on each side with the tree's
//   value there: the background, as a rule, so that fog fades out. The index space may be as wide
//   as OpenVDB's (+-2^31); dims are 64-bit and nothing is sized by them.
// - Values are the tree's, inactive ones too. A level set delivers its signed distances in world
//   units: negative inside, positive outside, clamped to the half width of its band, which is also
//   the background. Its surface is the value 0, so a renderer shows it with a transfer function
//   that is opaque below 0 and clear from 0 up. layout().name then ends in " (level set)".
// - Place: origin, spacing and axes follow from the grid's transform, rotation and shear included.
// - Memory: the tree's nodes are kept, the leaves' values are not: each read fetches and decodes
// the
//   leaves that it meets, a quarter of a MiB of them at a time. Nothing is read of tiles and of the
//   space between. Nothing is mapped: a file that is cut or overwritten meanwhile is an Error.
//
// OpenVDB itself is in a module of its own that is opened here, see vdb_module.h. Reads run on any
// number of threads at once.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "src/base/sources/volume_source.h"

namespace sluice {

// Opens the grid called `grid`; when empty, the first grid of floats or doubles, else the first of
// another scalar type. Throws Error: no such grid (the line lists the names and types), a grid that
// is not scalar, has no active voxels, or whose transform is not affine; a damaged file; a program
// without its module.
//
// `box`: the box delivered instead of the active voxels' box and a voxel around it, in index space;
// it must hold all active voxels, of which there may then be none.
//
// occupancy() gives the boxes of the leaves and of the tiles that differ from the background.
std::unique_ptr<VolumeSource> openVdb(const std::filesystem::path& path,
                                      const std::string& grid = "",
                                      const std::optional<Box3>& box = {});

}  // namespace sluice
