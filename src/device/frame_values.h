// The values that describe a frame to a device. Whoever asks for the picture resolves them from the
// camera, the transfer function and the volume (src/render/camera/frame_setup.h).
//
// Index space: positions in voxels, voxel (i, j, k) at (i, j, k). A pixel's ray in index space is
//   p(k) = origin + (k + 1/2) * step  at slice k, with
//   origin = origin0 + x * origin_dx + y * origin_dy,   step = step0 + x * step_dx + y * step_dy
// for pixel (x, y), y upwards from the lower left, at its centre (x + 1/2, y + 1/2). Both parallel
// and perspective views have this form. A box is half-open along the ray: of two boxes that share a
// face, exactly one takes each sample, because both compute the face's slice from the same numbers.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "src/base/looks/surface_look.h"
#include "src/base/values/vec.h"
#include "src/device/mode.h"
#include "src/device/shading/expected_look.h"
#include "src/device/shading/light_volume.h"
#include "src/device/shading/lighting.h"
#include "src/device/view_values.h"
#include "src/volume/voxels/device_voxel.h"

namespace sluice {

// See the top: the rays of a view in index space.
struct RayGrid {
  Vec3d origin0, origin_dx, origin_dy;
  Vec3d step0, step_dx, step_dy;
};

// Keeps index positions p with dot(normal, p) <= offset.
struct ClipPlane {
  Vec3d normal;
  double offset = 0;
  friend bool operator==(const ClipPlane&, const ClipPlane&) = default;
};

// Colours and opacities by device value: entry e of `rgba` is for device values around
// lo + e * (hi - lo) / (entries - 1); a sample takes the nearest entry, clamped, or interpolates.
struct LookUp {
  ValueRange device_range;
  ValueRange volume_range = {};  // all device values of the volume, or an estimate
  bool interpolates = false;
  // r, g, b not premultiplied; opacity of one unit length, not corrected for the step. In modes
  // other than composite a sample takes part if the opacity is above 0. Towards the last entries
  // before one of opacity 0 its part fades, so that rounding at an end of the visible values
  // changes a picture by little.
  std::vector<float> rgba;
  // Composite only: the opacity is multiplied by a factor that depends on the gradient's magnitude,
  // see lighting.h. Row r of `factors` is for magnitudes[r], device values a world unit, and has
  // one factor, or one an entry; linear between rows and entries, constant beyond. Empty: no
  // factor. Otherwise chunks carry a ghost layer around each block.
  std::vector<double> magnitudes = {};
  std::vector<float> factors = {};
  // Composite only: values are labels, see TransferFunction. A sample takes the value whose texels,
  // among the eight around it, have the greatest weight together; of two values with the same
  // weight (to kLabelTie), the greater. Chunks with shares (ChunkTexels) have a rule of their own,
  // see label_shares.h.
  bool labels = false;
  // Composite only, not of labels: see FrameSetup::has_surfaces. Ascending by level, at most
  // kMostSurfaces.
  std::vector<SurfaceLevel> surfaces = {};
  // Composite only, not of labels: how texels of chunks with spreads look. Modes other than
  // composite look at the means alone, and so do gradients. Null if no such chunk is drawn.
  ExpectedLookPtr expected = {};
};
inline constexpr double kLabelTie = 1e-3;
// The frames of a look share it: the same pointer is the same table.
using LookUpPtr = std::shared_ptr<const LookUp>;

// The places at which a ray is sampled. Most modes: the view's slices. Maximum and
// minimum: where the ray meets the planes of texel centres of its main axis, the one it runs along
// most (in voxels; of axes alike to kAxisTie the first); at `planes_a_voxel` - 1 places between two
// planes; and at both ends of its way through what is shown. What is shown are the cells
// FrameSetup::shown, cut by the clip planes and by the first slice in front of the eye. So along an
// axis of the volume the extreme is that of the texels themselves. In any direction no two samples
// are more than a texel apart on any axis, and a ray through a side face has the value there. An
// end within kEndMargin of a plane counts as that plane's sample. The faces of boxes belong to them
// in these modes, to kPlaneEdge of a voxel; a sample that two boxes share changes the extreme once.
inline constexpr double kAxisTie = 1e-4, kPlaneEdge = 1e-3, kEndMargin = 2 * kPlaneEdge;
// The same margin in places; a voxel has `planes_a_voxel` of them.
constexpr double endMargin(int planes_a_voxel) {
  return std::min(kEndMargin * planes_a_voxel, 0.25);
}

struct FrameSetup {
  PictureSize size;
  Projection projection = Projection::kOrtho;
  RayGrid rays;
  // Rows x, y and w of clip space, from (index position, 1).
  std::array<std::array<double, 4>, 3> clip_from_index{};
  int64_t first_slice = 0;                   // slices below lie behind the eye
  double first_depth = 0, depth_step = 1;    // world depth of slice k: first + (k + 1/2) * step
  std::array<double, 4> depth_from_index{};  // the row that takes (index position, 1) to its depth
  // World depths between which depth colours samples: of what the transfer function shows, or of
  // the corners of `shown`; in front of a perspective eye. Samples beyond have the colours of the
  // ends.
  std::array<double, 2> shown_depths{};
  // Unit lengths between samples: this for a parallel view; for a perspective one times the length
  // of (u tan_half.x, v tan_half.y, 1), u and v from -1 to 1. Opacity is corrected by it.
  double slice_length = 1;
  double tan_half_x = 0, tan_half_y = 0;
  DeviceType type = DeviceType::kU8;
  LookUpPtr look_up = std::make_shared<const LookUp>();
  Mode mode = Mode::kComposite;
  Box3 shown;              // cells that may show: the volume's, or a crop's
  int planes_a_voxel = 1;  // maximum and minimum, see above
  // Attenuated maximum: a sample counts with its place between these device values, 0 to 1, the
  // first of which may be the greater. Of samples of w_1, w_2, ... a pixel shows the greatest of
  //   w_k * exp(-attenuation * length * (w_1 + ... + w_(k-1))),
  // `length` being the unit lengths between samples. Samples that do not take part count as 0.
  std::array<double, 2> window{0, 1};
  double attenuation = 0;
  // Modes that colour by depth (depth_code.h): colours from the nearest of `shown_depths` to the
  // farthest, at even distances, linear in between. `window` as above, ascending in values.
  std::vector<Vec3d> depth_colors;
  double opacity_threshold = 1;      // a ray ends inside a box at this opacity; 1: never
  bool with_depth = false;           // composite only: the picture gets a depth channel
  bool counts_taken = false;         // composite only, not with depth: takenSamples() can be asked
  bool shades_every_sample = false;  // also reads, lights and blends samples that show nothing
  bool skips = false;  // may leave out samples that show nothing, or lie behind opaque
  bool lit = false;    // composite only: chunks carry a ghost layer around each block
  // Composite only, and not of labels or chunks with spreads: sample k stands for all values on the
  // ray from slice k - 1/2 to k + 1/2, between which they are taken to change linearly, see
  // IntegratedLook. Light and gradients are those of slice k. Both places lie within a voxel of it,
  // so that the ghost layer around each block has their texels, and beyond the volume its outermost
  // ones continue. Boxes take in all cells within a voxel of one that shows something.
  bool integrates = false;
  // Composite only, not of labels: the surfaces of the look-up are drawn together with its
  // opacities, which may be 0 everywhere. Slice k stands for the way from slice k - 1/2 to k + 1/2,
  // as it does for a frame that integrates, and slices are at most a texel apart along any axis. A
  // surface shows where the value passes its level between these two places, at the first of
  // several such places in order of the levels; in chunks with spreads the value is the mean. Its
  // normal is the gradient there: the differences between the eight corners of a unit cube around
  // it, in texels. What
  // slice k shows of the opacities is divided by the surfaces in proportion to the parts of the
  // way.
  //
  // The place between two slices is computed without the box, in steps of 1 / kPlaceGrid voxels
  // from a voxel that all boxes share, and the values there from the texels as they are. So
  // neighbouring boxes find the same value, and exactly one of them has a surface next to their
  // face.
  bool has_surfaces = false;
  // Composite only, unlit or lit, nothing else: further channels on the same grid, which are one
  // medium with this one. Theirs are look_up, type, lit and flat. Boxes come with their channels
  // (BoxDraw), those of a block one behind the other and of one scale. A sample blends all channels
  // whose boxes hold it: of opacities a_c and colours c_c its opacity is
  // a = 1 - (1 - a_1) (1 - a_2) ..., and its colour (a_1 c_1 + a_2 c_2 + ...) / (a_1 + a_2 + ...).
  std::vector<FrameSetup> others = {};
  // The picture is added to those of other channels. A device may draw it faster and with rounding
  // that differs from that of a picture of one channel; it draws all frames of a channel alike.
  bool is_one_of_several = false;
  // Composite only: colours are darkened by this share at the farthest of `shown_depths`, by none
  // at the nearest, and in proportion in between.
  double depth_cueing = 0;
  // Composite only: the slices of the ray of pixel (x, y) lie farther by this share, 0 to 1, of a
  // slice times blueNoise() at (x, y): slice k at k + 1/2 + jitter * noise.
  double jitter = 0;
  // Others draw the rest of the picture: it ends with Device::endPart(), or, of modes other than
  // composite and a device without it, with a picture of the numbers of partial_picture.h.
  bool is_part = false;
  uint64_t most_part_bytes = UINT64_MAX;  // limit for the part; drawing more throws Error
  Lighting lighting;
  LightVolumePtr light = {};  // lit only; null: all light arrives everywhere
  // Camera-space direction (right, up, toward the viewer) of one device value more a voxel along
  // each index axis: unit axis / spacing.
  std::array<Vec3d, 3> camera_gradient{};
  double flat = 1;                     // device values a world unit, see Lighting
  std::vector<ClipPlane> clip_planes;  // at most kMostClipPlanes
};
// As many as people may ask for, and the sides of a box.
inline constexpr size_t kMostClipPlanes = 12;
// See FrameSetup::has_surfaces. A power of two, so that differences of such places are exact.
inline constexpr int kPlaceGrid = 8192;
// The voxel from which such places count.
inline Vec3d placeBase(const FrameSetup& setup) {
  const Vec3d origin = setup.rays.origin0;
  return {std::floor(origin.x), std::floor(origin.y), std::floor(origin.z)};
}

// The map from index positions to the texels of a box: index position p has the coordinate
// p[axes[a]] * scale[a] + offset[a] along axis a of the chunk, texel centres at integers.
//
// Index space has the full resolution. The voxels of a coarser level lie in it as their centres do:
// a texel that is the mean of f voxels along an axis has scale 1 / f and, with the first voxel in
// the first texel, offset -(f - 1) / (2 f). So cells begin on voxel planes at any level, and texels
// need not.
struct TexelMap {
  std::array<int, 3> axes{0, 1, 2};  // a turn: the volume's axes in the chunk's order
  Vec3d scale{1, 1, 1};              // texels a voxel, > 0; along the chunk's axes, as `offset`
  Vec3d offset;                      // texel coordinate of index position 0

  constexpr Vec3d operator()(Vec3d p) const {
    return Vec3d{p[axes[0]], p[axes[1]], p[axes[2]]} * scale + offset;
  }
  // The scale along the volume's axes.
  constexpr Vec3d indexScale() const {
    Vec3d result;
    for (int a = 0; a < 3; ++a) result[axes[static_cast<size_t>(a)]] = scale[a];
    return result;
  }
};

// How much of a surface that lets light through a box draws at index position p: the product of
//   clamp(start[i] + slope[i] * p[i % 3], 0, 1)
// over all i, as a share of the surface's extinction: for a share of w, an opacity of a becomes
// 1 - (1 - a)^w. Opaque surfaces are drawn in full. Where parts of the volume of two levels of
// resolution meet, boxes of both overlap, and their shares add up to 1: one level's surface passes
// into the other's, and no ray meets it twice or not at all although they differ.
struct LevelFade {
  std::array<double, 6> start{1, 1, 1, 1, 1, 1}, slope{};

  friend bool operator==(const LevelFade&, const LevelFade&) = default;
};

// The most boxes that join another one at seams: at a corner of a block seven others meet it.
inline constexpr size_t kMostJoined = 7;

// A box of cells to resample from one resident chunk: p with cells.lo <= p < cells.hi. Samples up
// to a texel beyond the outermost texels of the chunk have the values of those.
struct BoxDraw {
  uint64_t chunk = 0;  // id
  Box3 cells;
  TexelMap texels;
  uint32_t layer = 0;  // layer of a part, see partial_picture.h
  // The channel of a frame of several, 0 for the setup's own, and whether the box joins the one
  // before it, or the one that this one joins. In frames with surfaces, a box of another chunk
  // beside one that it joins lies in that one's cells: its surfaces are drawn slice by slice with
  // what that box shows.
  uint32_t channel = 0;
  bool joins = false;
  // Frames with surfaces: this box lies beside the cells of another one of the chunk, in texels
  // around it. No opacities are drawn in it, and of surfaces the opaque ones alone if `fade` is not
  // set: where parts of the volume that are of other levels of resolution meet, a surface may lie
  // on one side of a face for the one and on the other side for the other, so that neither would
  // show it.
  std::optional<Box3> beside = {};
  // Frames with surfaces: the share of those that let light through.
  std::optional<LevelFade> fade = {};
};

// Which faces of a box lie on faces of the cells that may show: at these a ray enters or leaves
// what is shown; at others it goes on to the next box.
struct OuterFaces {
  std::array<bool, 3> lo{}, hi{};
};
constexpr OuterFaces outerFaces(const FrameSetup& setup, const Box3& cells) {
  OuterFaces outer;
  for (int a = 0; a < 3; ++a) {
    outer.lo[static_cast<size_t>(a)] = cells.lo[a] <= setup.shown.lo[a];
    outer.hi[static_cast<size_t>(a)] = cells.hi[a] >= setup.shown.hi[a];
  }
  return outer;
}

// The setup of a channel's look, see FrameSetup::others.
inline const FrameSetup& setupOfChannel(const FrameSetup& setup, size_t channel) {
  return channel == 0 ? setup : setup.others[channel - 1];
}

// Whether chunks with spreads may be drawn.
inline bool drawsSpreads(const FrameSetup& setup) {
  const LookUp& look_up = *setup.look_up;
  return !traitsOf(setup.mode).has_colors || look_up.labels || look_up.expected != nullptr;
}

// A square grid of side x side cells on a plane of index space, seen from the eye: rows x, y and w
// of clip space, from (x, y, 1) in cells; cell (i, j) is [i, i + 1) x [j, j + 1).
struct MapGrid {
  int side = 1;
  std::array<std::array<double, 3>, 3> clip_from_map{};
};

}  // namespace sluice
