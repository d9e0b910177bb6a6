// The values that the SIMD kernels read: a frame, its boxes and the pixels of a tile as plain
// single-precision values, so that one definition serves the code of every target. Made by
// kernel_frame.h and kernel_box.h; nothing here owns memory.
//
// The folder: composite_kernels.cpp, blended_kernels.cpp and mode_kernels.cpp are the kernels, each
// compiled once for every instruction set (kernel_set.h). The .inl files are parts of them, one
// subject each: rays, texels, colours, lighting, surfaces.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "src/base/looks/channel_look.h"
#include "src/cpu/kernels/color_ramp.h"
#include "src/device/frame_values.h"
#include "src/device/shading/integrated_look.h"

namespace sluice {

using Float3 = std::array<float, 3>;

// A tile is kTileSide x kTileSide pixels, drawn by one thread at a time.
inline constexpr int kTileSide = 16;
inline constexpr int kTilePixels = kTileSide * kTileSide;
// The widest packet: pixels that one instruction works on.
inline constexpr int kMostLanes = 16;

// Channels that are blended at the most: a volume's, and a volume over it.
inline constexpr size_t kMostBlended = kMostChannels + 1;

// FrameSetup in single precision; rays relative to origin0.
struct KernelFrame {
  int width = 0, height = 0;
  Combining combining = Combining::kBlend;
  bool on_planes = false, codes_depth = false;  // see ModeTraits
  DeviceType type = DeviceType::kU8;
  Float3 origin_dx{}, origin_dy{}, step0{}, step_dx{}, step_dy{};
  float first_slice = 0, first_depth = 0, depth_step = 1, slice_length = 1;
  // FrameSetup::depth_cueing: the part by which slice k + 1/2 is darkened is cue_start + k *
  // cue_step, from 0 to cue_most.
  float cue_start = 0, cue_step = 0, cue_most = 0;
  // FrameSetup::jitter: blueNoise(), or null if there is none, and the share of it.
  const float* noise = nullptr;
  float jitter = 0;
  int clip_planes = 0;
  std::array<std::array<float, 4>, kMostClipPlanes> clip_plane{};  // normal, offset from origin0
  float planes_a_voxel = 1, end_margin = 0;                        // see endMargin()
  bool perspective = false, with_depth = false, counts_taken = false, labels = false;
  bool shades_every_sample = false, interpolates = false;
  std::array<float, 4> pixel_ray{};  // u tan x = x * [0] + [1], v tan y = y * [2] + [3]
  // A ray ends inside a box at the first, for good at the second; both above 1 if it never does.
  float box_opacity = 2, ray_opacity = 2;

  // The look-up of lookUpTexels(): entry = value * entry_scale + entry_offset, from 0 to
  // last_entry.
  const float* entries = nullptr;  // rgba
  // The same in 64 bits an entry, see packed_entries.h; composite that does not interpolate, else
  // null.
  const int64_t* packed_entries = nullptr;
  float color_unit = 1, opacity_unit = 1;  // factors of packed_entries
  // Frames of several channels: the entries as a ramp, or null if they follow none.
  const ColorRamp* ramp = nullptr;
  float entry_scale = 0, entry_offset = 0, last_entry = 0;
  // Pre-integrated frames, else null: IntegratedLook::sums, and the exponent of slice_length, or of
  // a unit length with factors, that a sum of 1 stands for.
  const int32_t* sums = nullptr;
  float sums_unit = 1, sums_last = 1;   // the last entry
  const int32_t* sums_alone = nullptr;  // the second row of the sums
  float one_value = 0, near_entry = 0;  // the look's
  float least = 0, greatest = 0;        // values of the first and of the last entry
  // FrameSetup::window as its first value and 1 / its length, and FrameSetup::attenuation of the
  // way from slice to slice.
  float window_lo = 0, window_scale = 0, attenuation = 0;
  float least_visible = 0, most_visible = 0;  // values beyond these have no opacity

  // FrameSetup::has_surfaces: the surfaces of the look-up, ascending by level, with their colours
  // not premultiplied; 0 of them in other frames. `has_opacities`: the look-up shows something
  // else.
  int surfaces = 0;
  std::array<float, kMostSurfaces> level{}, surface_opacity{};
  std::array<std::array<float, kMostSurfaces>, 3> surface_rgb{};
  Float3 place_origin{};  // of the pixel at the lower left corner, from placeBase()
  bool has_opacities = true;
  // The same for boxes beside others, see BoxDraw::beside: of opaque surfaces, and at seams of all.
  const KernelFrame *beside = nullptr, *at_seam = nullptr;

  // For chunks with spreads: LookUp::expected as premultiplied rows. A mean's entry is mean *
  // mean_scale + mean_offset; a spread's row, from 1 on, is sqrt(spread * spread_scale) * rows.
  const float* expected = nullptr;
  float mean_scale = 0, mean_offset = 0, spread_scale = 0;
  int expected_entries = 0, expected_rows = 0;
  // For chunks with shares: LookUp::rgba, whose opacities are those of a unit length.
  const float* label_entries = nullptr;

  // Gradients: lit, or factors of the opacity.
  bool lit = false, corrects = false;
  std::array<Float3, 2> toward{}, halfway{};  // `toward` times the light's strength and diffuse
  std::array<float, 2> specular{};
  // evenDiffuse() and evenSpecular() of each light, and the device values of a spread_scale of 1.
  std::array<float, 2> even_diffuse{}, even_specular{};
  float spread_unit = 0;
  float ambient = 0, flat = 0, shininess = 0;
  int whole_shininess = 0;  // the same if it is a small whole number, else 0
  // FrameSetup::light: its texels, the last and the last but one along each axis, and strides in
  // bytes; null: all light arrives. In squares, see light_squares.h, it has no key light.
  const std::byte* light = nullptr;
  bool light_in_squares = false;
  bool key_light_varies = true, other_light_varies = true;  // see LightVolume
  Float3 light_hi{}, light_last{}, light_stride{};
  float key_share = 0;
  int rows = 0, factor_entries = 0;
  const float* factors = nullptr;      // rows x factor_entries
  const float* row_starts = nullptr;   // magnitudes
  const float* row_growths = nullptr;  // 1 / the distance to the next
};

inline constexpr float kInside = 1e30F;

// A box of cells with the texels around them: at least two along each axis. Coordinates of voxels
// count from the box's lower corner, along the volume's axes; coordinates of texels count from the
// first texel that the box reads, along the chunk's axes.
struct KernelBox {
  Float3 lo{}, hi{};  // relative to origin0
  float first_slice = 0;
  // Voxel coordinates of pixel (x, y) at first_slice + 1/2: voxel0 + x * voxel_dx + y * voxel_dy.
  // They are doubles: single precision is left for the way from a tile's corner on.
  Vec3d voxel0, voxel_dx, voxel_dy;
  std::array<int, 3> axes{0, 1, 2};
  // Texel coordinates in the volume's order: voxels * texel_scale + texel_start.
  Float3 texel_scale{1, 1, 1}, texel_start{};
  Float3 texel_hi{};                  // samples lie from 0 to here
  Float3 last_cell{};                 // texels from which on the last samples are interpolated
  bool clamps = false;                // some samples lie beyond the chunk's texels
  Float3 storage_lo{}, storage_hi{};  // the chunk's first and last texel
  const std::byte* texels = nullptr;  // the first of the box
  Float3 stride{};                    // in bytes
  bool has_spread = false;            // two numbers a texel, see ChunkTexels
  float texel_length = 1;             // see label_shares.h
  bool has_margin = false;            // a texel more on every side
  // Device values a world unit, camera space, of a value more a texel along each texel axis.
  std::array<Float3, 3> gradient{};
  float gradient_squares = 0;  // the sum of the squares of their lengths
  // See rough_light.h: kEdgeVoxels in texels, and kNoisePart of values a texel.
  float edge_texels = 0, noise_part = 0;
  // Texel coordinates of the frame's light, along the volume's axes: texel coordinates along the
  // chunk's axes light_axes * light_scale + light_start.
  std::array<int, 3> light_axes{0, 1, 2};
  Float3 light_scale{}, light_start{};
  // Modes that colour by depth: depth_start + dot(depth_along, texel coordinates along the chunk's
  // axes) is a depth from 0 to 1.
  Float3 depth_along{};
  float depth_start = 0;
  Float3 corner{};  // the lower corner, in voxels from placeBase()
  Float3 size{};    // in voxels
  // Maximum and minimum: 0 for a face at which rays enter or leave what is shown, else kInside, far
  // beyond any slice.
  Float3 inside_lo{}, inside_hi{};
  // Leaps, see leap_grid.h: distances of the chunk's bricks, null if every sample is taken; brick
  // coordinates of texel 0, the last brick, and strides in bricks.
  const uint8_t* distances = nullptr;
  Float3 brick_at{}, brick_last{}, brick_stride{};
  uint32_t layer = 0;      // layer of a part
  bool is_beside = false;  // BoxDraw::beside is set
  // BoxDraw::fade: factors start + slope * texel coordinate, two along each of the chunk's axes.
  bool fades = false;
  std::array<Float3, 2> fade_start{}, fade_slope{};
  // Blended channels: the box's. And the number of boxes behind this one in the list that join it,
  // whose pixels count with this one's: of other channels, or of seams (BoxDraw::joins), of which a
  // box has kMostJoined at most.
  uint32_t channel = 0, joined = 0;
  // Pixels that may see the box, [lo, hi).
  int x_lo = 0, y_lo = 0, x_hi = 0, y_hi = 0;
};

// The pixels of a tile, packet after packet. Each is kTilePixels floats.
struct TilePixels {
  int x = 0, y = 0;  // lower left pixel
  // Composite: red, green, blue, opacity; other modes: the numbers of their Combining.
  std::array<float*, 4> color{};
  float* depth_sum = nullptr;  // with_depth
  float* stopped = nullptr;    // 1 if a pixel takes no more samples
  uint64_t taken = 0;          // samples, added to
};

// The code of one target. All functions are pure but for the pixels, from any thread.
struct Kernels {
  const char* name = "";
  int packet_width = 1, packet_height = 1;
  // Draws the boxes of these indices in turn: composite, and the other modes.
  void (*composite)(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                    size_t count, TilePixels& tile) = nullptr;
  void (*other)(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                size_t count, TilePixels& tile) = nullptr;
  // Draws boxes with those that join them as one medium, `frames` of so many channels.
  void (*blended)(const KernelFrame* const* frames, size_t channels, const KernelBox* boxes,
                  const uint32_t* indices, size_t count, TilePixels& tile) = nullptr;
  // The same with a tile for each channel, whose pictures are added.
  void (*added)(const KernelFrame* const* frames, size_t channels, const KernelBox* boxes,
                const uint32_t* indices, size_t count, TilePixels* tiles) = nullptr;
  // How many samples that would be if no ray ended.
  uint64_t (*count)(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                    size_t count, const TilePixels& tile) = nullptr;

  // The index of the tile's pixel (x, y) in its arrays.
  int placeOf(int x, int y) const {
    const int packet = (y / packet_height) * (kTileSide / packet_width) + x / packet_width;
    return packet * packet_width * packet_height + (y % packet_height) * packet_width +
           x % packet_width;
  }
};

// The kernels of a frame with its channels, the setup's own first: of several the boxes are drawn
// with those that join them. The values that it points to must outlive it.
struct FrameKernels {
  const Kernels* kernels = nullptr;
  std::array<const KernelFrame*, kMostBlended> frames{};
  size_t channels = 0;

  const KernelFrame& frame() const { return *frames[0]; }
  // Draws the boxes of these indices in turn.
  void draw(const KernelBox* boxes, const uint32_t* indices, size_t count, TilePixels& tile) const {
    if (channels > 1)
      kernels->blended(frames.data(), channels, boxes, indices, count, tile);
    else if (frame().combining == Combining::kBlend)
      kernels->composite(frame(), boxes, indices, count, tile);
    else
      kernels->other(frame(), boxes, indices, count, tile);
  }
};

}  // namespace sluice
