// The attributes.json of N5: of a data set, as a ZarrArray, and of a group, as the places of its
// levels.
//
// N5 counts axes from the fastest, x, so extents, factors and the numbers of a block's path come in
// the other order than Zarr's; a ZarrArray and a ZarrImage have them turned. Nothing here touches a
// file, so that the parsers can be fuzzed. Sources: the N5 specification, version 4; the metadata
// of BigDataViewer, n5-viewer and n5-ij (scales, downsamplingFactors, resolution, pixelResolution,
// units) and of COSEM (transform).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/zarr/metadata/zarr_array.h"
#include "io/zarr/metadata/zarr_image.h"

namespace sluice {

// Whether the attributes are a data set's. Throws Error, which starts with `path`: no JSON.
bool isN5Array(std::string_view text, const std::string& path);

// Throws Error, which starts with `path`: no data set, or one that cannot be read: more than 5
// axes, integers of 64 bits, other codecs than raw, gzip, zstd, xz and
// blosc.
ZarrArray parseN5Array(std::string_view text, const std::string& path);

// The places of voxels as attributes give them, x first.
struct N5Place {
  // Finest voxels a voxel of each level (a group's), or of this data set alone; empty: not given.
  std::vector<std::vector<double>> factors;
  // World units a voxel, of a group those of the finest level; the first voxel's centre. Empty: not
  // given.
  std::vector<double> resolution, translation;
  std::vector<std::string> axes, units;  // empty: not given
};

// Throws Error, which starts with `path`.
N5Place parseN5Place(std::string_view text, const std::string& path);

// The image of a group and its levels "s0", "s1" and so on, from the places that each level's own
// attributes give; or of one data set of `axes` axes. Levels are means of the finer voxels that
// they cover, as the programs that write N5 make them. Throws Error, which starts with `path`:
// numbers that do not fit the axes. Requires: levels not empty.
ZarrImage n5Image(const N5Place& group, const std::vector<N5Place>& levels, size_t axes,
                  const std::string& path);

// The name of a level's folder.
std::string n5LevelName(size_t level);

}  // namespace sluice
