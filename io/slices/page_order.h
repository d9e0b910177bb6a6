// PageOrder: the pages of TIFF files as the slices, channels and time steps of a volume. A plain
// value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_times.h"
#include "src/base/values/vec.h"

namespace sluice {

// A page, by its place in PageOrder::files.
struct PagePlace {
  uint32_t file = 0;
  int64_t page = 0;
  friend bool operator==(const PagePlace&, const PagePlace&) = default;
};

struct PageOrder {
  int64_t slices = 1, channels = 1, frames = 1;
  // Planes between neighbouring slices, channels and frames, in the order of `places`.
  int64_t slice_step = 1, channel_step = 1, frame_step = 1;
  // Empty: plane i is page i of the file.
  std::vector<PagePlace> places;
  // Names of the files of a set, this one among them, all in one folder; empty: this file alone.
  std::vector<std::string> files;
  // OME's description fits the pages, or those of the set.
  bool is_described = false;
  // The file of the same folder that describes the set instead; empty: none.
  std::string companion;
  Vec3d spacing{1, 1, 1};
  Vec3d origin;                   // position of the first voxel, in the spacing's unit
  std::string unit;               // empty: the spacing is not known in one
  std::optional<TimeAxis> times;  // of the frames; unset: not told
  // The reason why the spacing is partly a guess, and why positions that the description gives are
  // not used, each a line without the file's name; empty: no reason.
  std::string spacing_fault, place_fault;
  bool tells_place = false;                // there is a position, whether it is used or not
  std::vector<std::string> channel_names;  // may be empty
  std::vector<StoredLook> channel_looks;   // empty: the description says nothing of them
  // ImageJ's stacks beyond 4 GiB: this many pages follow the first without tables of their own.
  int64_t untold_pages = 0;
  std::vector<std::string> notes;  // one line each, without the file's name

  int64_t plane(int64_t frame, int64_t slice, int64_t channel) const {
    return frame * frame_step + slice * slice_step + channel * channel_step;
  }
  PagePlace place(int64_t plane) const {
    return places.empty() ? PagePlace{0, plane} : places[static_cast<size_t>(plane)];
  }
};

// Each page a slice.
inline PageOrder plainPages(int64_t pages) {
  PageOrder order;
  order.slices = pages;
  return order;
}

// The most planes that a description may name.
inline constexpr int64_t kMostPlanes = 100'000'000;

// Planes that the counts name; -1: more than that.
inline int64_t planesOf(const PageOrder& order) {
  int64_t planes = order.slices;
  for (const int64_t factor : {order.channels, order.frames})
    if (__builtin_mul_overflow(planes, factor, &planes) || planes > kMostPlanes) return -1;
  return planes;
}

}  // namespace sluice
