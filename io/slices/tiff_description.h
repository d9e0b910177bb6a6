// Parses the description in a TIFF, which orders its pages as a volume: ImageJ's lines and OME's
// XML.
//
// Pure: no file is touched, so that damage can be tried. Sources: ImageJ's TiffDecoder conventions
// ("ImageJ=1.53t", hyperstacks in the order channel, slice, frame) and the OME-TIFF specification
// (one <Pixels> element, its dimension order and its <TiffData> blocks).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/values/vec.h"
#include "src/base/values/volume_channels.h"

namespace sluice {

// The pages of a file as slices, channels and time steps.
struct PageOrder {
  int64_t slices = 1, channels = 1, frames = 1;
  // Pages between neighbouring slices, channels and frames.
  int64_t slice_step = 1, channel_step = 1, frame_step = 1;
  // Pages in the order of the above; empty: page i is the i-th.
  std::vector<int64_t> pages;
  Vec3d spacing{1, 1, 1};
  std::string unit;                        // empty: the spacing is not known in one
  std::vector<std::string> channel_names;  // may be empty
  std::vector<StoredLook> channel_looks;   // empty: the description says nothing of them
  // ImageJ's stacks beyond 4 GiB: this many pages follow the first without tables of their own.
  int64_t untold_pages = 0;
  std::vector<std::string> notes;  // one line each, without the file's name

  int64_t page(int64_t frame, int64_t slice, int64_t channel) const {
    const int64_t at = frame * frame_step + slice * slice_step + channel * channel_step;
    return pages.empty() ? at : pages[static_cast<size_t>(at)];
  }
};

// `pages` tables were found in the file. `pixels_a_unit` are its resolution tags, 0 if it has none:
// ImageJ keeps the pixel's size there. A description of neither kind, or one that does not fit the
// pages, gives `pages` slices; the latter with a note.
PageOrder parseTiffDescription(std::string_view description, int64_t pages, double pixels_a_unit_x,
                               double pixels_a_unit_y);

}  // namespace sluice
