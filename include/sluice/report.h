// A Renderer's reports on its levels of memory, its look, and voxels. Plain data.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace sluice {

// Counters of one level since the Renderer was made.
struct LevelReport {
  uint64_t requests = 0, hits = 0, misses = 0, loads = 0, evictions = 0;
  uint64_t current_bytes = 0, peak_bytes = 0;
  uint64_t budget_bytes = 0;  // limit of current_bytes and peak_bytes
};

// The last picture, and the levels of memory as they are now.
struct RenderReport {
  // The last picture: wall clock time, and the part of it for drawing; the share left out at its
  // time limit (Image::missing_share); blocks that it found empty, trimmed and full.
  double seconds = 0, draw_seconds = 0;
  double missing_share = 0;
  int64_t white = 0, grey = 0, black = 0;
  double step_vox = 1;  // see PictureOptions
  // Levels of resolution in the picture of a volume that has several, the finest first, 0 being the
  // data as stored; the share of the visible cells that coarser levels show; whether it is as fine
  // as PictureOptions::pixel_error asks; and if not, whether another picture of this view would be
  // finer (Image::will_improve), or the memory has no room.
  std::vector<int> levels;
  double coarse_share = 0;
  bool is_refined = true, will_improve = false;
  // Why the last picture shows nothing, in one line: "the camera looks past the visible part of the
  // volume". Empty if it shows something.
  std::string why_empty;
  // Which of several channels show nothing, and why, in one line; empty if none or all do.
  std::string empty_channels;
  // Why the pictures of two volumes are added that would be blended without an option for something
  // else, in one line; empty: they are blended, or added anyway.
  std::string why_added;
  uint64_t pages_loaded = 0;

  // Level 1: voxels taken from the volume's files, as they are stored, and metadata of stores, but
  // no headers, and no pages that tell whether a file has changed.
  uint64_t read_bytes = 0;
  LevelReport volume_buffer, texture_buffer, texture_cache;
  uint64_t pages = 0, page_bytes = 0;  // pages of the texture cache

  // Maps, if they were asked for. A page's chunk: a number from 1 on that pages of one chunk share,
  // 0 if the page is free.
  std::vector<uint32_t> page_chunks;
  // Blocks along x, y, z, and the class of each, x fastest: 0 white, 1 grey, 2 black. Empty if
  // there are more than kMostMappedBlocks.
  static constexpr int64_t kMostMappedBlocks = int64_t{1} << 22;
  std::array<int64_t, 3> block_grid{0, 0, 0};
  std::vector<uint8_t> block_classes;
};

// How a picture that was not drawn yet will be sampled.
struct PictureSampling {
  // See PictureOptions. Surfaces, thin parts and short time limits may change it as they are drawn.
  double step_vox = 1;
  bool from_levels = false;  // parts of it may show coarser levels of resolution
};

// The cost of a picture that was not drawn yet.
struct PicturePlan {
  // Blocks that are empty, trimmed and full.
  int64_t white = 0, grey = 0, black = 0;
  // The textures of one way to trim and merge blocks.
  struct Algorithm {
    std::string name;
    uint64_t chunks = 0, pages = 0, bytes = 0, binds = 0;
  };
  // Conventional, clipped, trimmed and merged. Pictures are drawn merged.
  std::array<Algorithm, 4> algorithms;
  uint64_t clusters = 0;
  // A first picture reads the blocks that show something: their number, and the bytes of their
  // voxels. If the memory does not hold all of them, some are read again.
  int64_t read_blocks = 0;
  uint64_t read_voxel_bytes = 0;

  // The memory that the picture takes.
  struct Memory {
    // RendererOptions::memory_bytes, the least that works, and what the picture takes of it; parts
    // of that for the min-max arrays and for the pixels.
    uint64_t budget_bytes = 0, least_bytes = 0, buffer_bytes = 0;
    uint64_t index_bytes = 0, picture_bytes = 0;
    // Bytes outside the budget, bytes with it, and bytes that this process may have.
    uint64_t program_bytes = 0, peak_bytes = 0, machine_bytes = 0;
    bool fits = false;
  };
  Memory memory;

  // The part of the picture that one level of resolution draws.
  struct Level {
    int level = 0;
    int64_t blocks = 0, cells = 0;
  };
  // The finest first; empty for a volume with one level.
  std::vector<Level> levels;
  // These have the same meaning as in RenderReport.
  double coarse_share = 0;
  bool is_refined = true;

  double classify_seconds = 0, plan_seconds = 0;

  // The most blocks that a first picture reads, and the bytes of their voxels: as many as
  // read_blocks if the memory holds all of these.
  int64_t most_read_blocks = 0;
  uint64_t most_read_voxel_bytes = 0;

  // The plan of each channel, if the picture shows several, or a volume over another one. The
  // numbers above are then the sums of theirs, but for those of the levels, which are the first
  // channel's.
  std::vector<PicturePlan> channels;
  // In the plan of a channel: its number, or "over", and its name as the file has it.
  std::string channel, name;
};

// How often values occur: bin i of n holds lo + (hi - lo) / n * [i, i + 1), the last one hi too.
struct ValueHistogram {
  double lo = 0, hi = 0;
  std::vector<uint64_t> counts;
};

// A look as it is drawn, even if it was chosen automatically.
struct ShownLook {
  // The colour of a value.
  struct Color {
    double value = 0;
    std::array<double, 3> rgb;  // 0 to 1, as shown on a screen
  };
  // The opacity of a value, from 0 to 1, of one voxel length.
  struct Opacity {
    double value = 0, opacity = 0;
  };
  // The name that a table gives to a label.
  struct LabelName {
    double label = 0;
    std::string name;
  };
  // The look of one of several channels that pictures show together.
  struct Channel {
    std::string channel;          // its number, as LookOptions::Channel names it
    std::string name;             // as the file has it; may be empty
    std::array<double, 3> rgb;    // the colour at the end of the range
    std::array<double, 2> range;  // its colours span these values
    double opacity = 0;  // the greatest, of one voxel length; for labels the factor of theirs
    std::vector<Color> colors = {};  // ascending by value, linear in between
    bool labels = false;             // its values are labels
  };
  std::vector<Color> colors;           // ascending by value, linear in between
  std::vector<Opacity> opacities;      // the same
  std::vector<Color> surfaces;         // in the order of LookOptions::surfaces
  std::vector<Channel> channels;       // empty if pictures show one
  std::vector<LabelName> label_names;  // of a table, ascending by label
  bool lit = false, labels = false;
  // The channels are one medium unless a picture has light that looks around, see
  // LookOptions::combine.
  bool blends = false;
  std::string options;   // Renderer::lookText()
  std::string transfer;  // the transfer function as a file of ours holds it, JSON
  std::vector<std::string> warnings;
};

// A place in the volume.
struct VoxelProbe {
  std::array<double, 3> voxel;  // from 0, in between as well
  std::array<double, 3> world;
  // Interpolated as drawing does; infinite beside an infinite voxel. Places beside a voxel that is
  // no number show nothing, and are no answer.
  double value = 0;
};

// Values of a slice, row after row. For axis x the rows run along y and the columns along z, for
// axis y along x and z, for axis z along x and y, in the order of the voxels.
struct SliceValues {
  int width = 0, height = 0;
  int64_t every = 1;          // voxel that was taken, along both
  std::vector<float> values;  // NaN for no number; infinite beyond 1e30, too
};

}  // namespace sluice
