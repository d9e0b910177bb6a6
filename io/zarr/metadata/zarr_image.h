// ZarrImage: the levels, axes and place in the world of an OME-Zarr image, from its .zattrs
// (version 0.1 to 0.4) or zarr.json (0.5, and 0.6 as far as its transformations are scalings and
// shifts). ZarrView: an array of 3 to 5 axes as a volume: which axis is x, y, z, time, channel, and
// the place of the voxels.
//
// Nothing here touches a file, so that the parser can be fuzzed. Source: OME-Zarr (NGFF) 0.1 to
// 0.6. What those cannot say, the directions of oblique axes and the scaling of values, sluice
// keeps under a key of its own ("sluice"), which other programs pass over. There "spreads" names a
// group inside the image's folder that has an array for each coarser level, of the same path and
// shape: the spreads of its voxels (volume_levels.h). "levels" names groups of the same kind for
// coarser levels that hold something else, by the words of zarrLevelsName().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/zarr/metadata/zarr_array.h"
#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_levels.h"
#include "src/base/sources/volume_source.h"
#include "src/base/sources/volume_times.h"

namespace sluice {

// The group of the spreads in stores that sluice packs.
inline constexpr const char* kZarrSpreadFolder = "spread";

// A group of coarser levels beside those of the image.
struct ZarrLevelGroup {
  LevelValues values = LevelValues::kUnknown;
  std::string folder;
};

struct ZarrAxis {
  std::string name, type, unit;  // type and unit may be empty
};

// The placement of an array in the world, one number for each of its axes.
struct ZarrPlace {
  std::vector<double> scale, translation;  // empty: not given
  bool is_translated = false;              // the array has a translation of its own
};

struct ZarrImage {
  std::vector<std::string> levels;  // folders of the arrays, the finest first; may be empty
  std::vector<ZarrPlace> places;    // one for each level
  std::vector<ZarrAxis> axes;       // empty: not given
  std::vector<double> scale,
      translation;                    // for the level asked for, one per axis; empty: not given
  std::vector<std::string> channels;  // their names, if the file gives them ("omero")
  std::vector<StoredLook> looks;      // their looks, as many; empty if it gives none
  // value = stored * value_scale + value_offset: of an image under the key "sluice", of an array by
  // itself as scale_factor and add_offset.
  double value_scale = 1, value_offset = 0;
  std::vector<double> missing;  // stored numbers that are no values
  // Stored numbers beyond these are no values; unset: no limit.
  std::optional<double> valid_least, valid_greatest;
  std::vector<std::string> notes;  // faults of the looks, in a few words each
  // Stored under the key "sluice".
  std::optional<std::array<Vec3d, 3>> directions;
  bool level_set = false;
  std::string spreads;  // folder of the levels' spreads; empty: there are none
  std::vector<ZarrLevelGroup> level_groups;
  LevelValues level_values = LevelValues::kUnknown;  // as far as the image says it
  std::optional<WorldFrame> frame;  // without: that of pictures, where the axes are an image's
};

// `level` is the folder whose scale is wanted; empty: the first. Axes also come from xarray's
// _ARRAY_DIMENSIONS and the dimension_names of a zarr.json. The CF conventions' attributes of an
// array, which xarray writes, are read if there is no image. Throws Error, which starts with
// `path`: not understood, no such level, a level outside of the folder.
ZarrImage parseZarrImage(std::string_view text, const std::string& path,
                         const std::string& level = "");

// The word for how levels were made; empty for kUnknown.
std::string_view zarrLevelsName(LevelValues values);
// The group of such levels in stores that sluice packs with levels of several kinds.
std::string_view zarrLevelsFolder(LevelValues values);
// The text for a frame under the key "sluice".
std::string_view zarrFrameName(WorldFrame frame);

// The numbers of the image's scale along axes of space, in their order.
std::vector<double> spaceScale(const ZarrImage& image);

struct ZarrView {
  VolumeLayout layout;            // all but the name
  std::array<size_t, 3> space{};  // the array's axes that are x, y and z
  std::optional<size_t> time, channel;
  std::optional<TimeAxis> times;   // unset: not told, or one step
  std::vector<std::string> notes;  // lines about times that are none
};

// Without names the axes are taken as z y x, t z y x and t c z y x; of four the first is the
// channel if `channel_wanted`. Throws Error, which starts with `path`: fewer than 3 or more than 5
// axes, others than x, y, z, t and c, a place that is not finite.
ZarrView viewZarr(const ZarrArray& array, const ZarrImage& image, bool channel_wanted,
                  const std::string& path);

}  // namespace sluice
