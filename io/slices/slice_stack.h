// A stack of PNG or TIFF slices as one volume: a file a slice, or the pages of one TIFF.
//
// Voxel (x, y, z) is column x, row y (row 0 on top) of slice z. A file of pages whose description
// tells that they are slices, channels and time steps (tiff_description.h) is read so; its spacing
// and unit are taken too. If it belongs to a set of OME-TIFF files, all of them are read. If each
// page has reduced images (SubIFDs), these are coarser levels. Decoded
// rows go through a small cache of bands of rows, and some pictures stay open with their decoders
// in place, so that reading block by block (x, then y, then z) decodes each row about once, not
// once a block. Both are bounded. Reads run on any number of threads at once; two that want the
// same band decode it once.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/files/channel_choice.h"
#include "src/base/sources/volume_source.h"
#include "src/base/threads/stop_token.h"

namespace sluice {

struct SliceOptions {
  std::optional<Vec3d> spacing = {};  // world units; unset: the file's, or 1, 1, 1
  ChannelWish channel = {};           // for a file of several channels
  // Limit of decoded rows and idle open pictures, until holdAtMost() changes it. A band of rows and
  // a picture a thread are held even if they are more.
  uint64_t held_bytes = uint64_t{32} << 20;
  size_t max_open_pictures = 64;  // in addition to those in use at the moment
  StopToken stop = {};            // ends opening and reading by Interrupted
};

// The slices in the order given, bottom (z = 0) first, or files of one set, in any order. Throws
// Error: a file is missing, no picture or damaged; a slice's size or type differs from the first
// one's (the message names it); one of several files that are no set has more than a page.
std::unique_ptr<VolumeSource> openSlices(const std::vector<std::filesystem::path>& files,
                                         const SliceOptions& options = {});

// All pictures of a folder in natural order. Throws Error as above; a folder without pictures, or
// with both PNG and TIFF pictures (give a pattern to choose).
std::unique_ptr<VolumeSource> openSliceFolder(const std::filesystem::path& folder,
                                              const SliceOptions& options = {});

}  // namespace sluice
