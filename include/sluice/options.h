// Options of a picture: what it shows and how. Plain data, with the defaults of `sluice render`.
#pragma once

#include <sluice/screen.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sluice {

// How values look. The first of these that is set makes the opacities: opacities, transfer_file,
// labels, threshold. Otherwise they are chosen from the values. Opacities given with a
// transfer_file keep the colours of that file.
struct LookOptions {
  // A ray shows its colours one behind the other; its greatest, least or mean value; the greatest
  // of its values dimmed by those in front of them; or its greatest value in a colour for its
  // depth.
  enum class Mode { kComposite, kMaximum, kMinimum, kAverage, kAttenuatedMaximum, kDepthMaximum };
  // Several channels: their pictures added up, as fluorescence adds up, or each sample of a ray
  // blended of all channels, as one medium: composite mode, channels of one grid.
  enum class Combine { kAdd, kBlend };
  // Whether light falls on surfaces, by the gradient.
  enum class Light { kChosen, kOn, kOff };
  // The opacity of a value.
  struct Opacity {
    double value = 0;
    double opacity = 0;  // 0 to 1, of one voxel length of the finest spacing
    friend bool operator==(const Opacity&, const Opacity&) = default;
  };

  // How one of several channels looks that are drawn together. What is not set follows from the
  // look of all channels, else from the file, else from the values.
  struct Channel {
    // Its number from 0, or its name; "over" for VolumeOptions::over.
    std::string channel = {};
    // A colour, "green" or "00ff00", a map, "labels", or the file of a table of labels.
    std::string map = {};
    std::optional<std::array<double, 2>> range = {};  // opacity rises over it from 0, too
    // At the end of the range; for labels the factor of their opacities, which are 1 without a
    // table. Unset: 0.05; labels of VolumeOptions::over 0.1; with a table 1.
    std::optional<double> opacity = {};
    friend bool operator==(const Channel&, const Channel&) = default;
  };

  // A surface where the volume has a value.
  struct Surface {
    double value = 0;
    double opacity = 1;      // 0 to 1, wherever it is seen, whatever the angle
    std::string color = {};  // "green" or "00ff00"; empty: the map's at the value
    friend bool operator==(const Surface&, const Surface&) = default;
  };

  // How the labels from the first to the last look; all labels if these are infinite. What is not
  // set stays as it is.
  struct Label {
    double first = 0, last = 0;
    std::string color = {};              // "green" or "00ff00"
    std::optional<double> opacity = {};  // of a voxel length, 0 to 1
    friend bool operator==(const Label&, const Label&) = default;
  };

  Mode mode = Mode::kComposite;
  // Composite mode, not with labels; at most 8. With threshold, opacity, opacities or transfer_file
  // they are drawn together with what those show, and otherwise alone. Parts at coarser levels have
  // the surfaces of the levels' means. Pictures with surfaces have plain samples at most a voxel of
  // the finest level in them apart.
  std::vector<Surface> surfaces = {};
  // A ramp: opacity 0 below it, a fifth of `opacity` at it, and that at the top of the values.
  std::optional<double> threshold = {};
  // At the top; unset: 0.05, or the automatic choice. For labels the factor of their opacities,
  // which are 1 without a table; unset: 1.
  std::optional<double> opacity = {};
  std::vector<Opacity> opacities = {};  // ascending by value, linear in between
  std::string transfer_file = {};       // our JSON, or ParaView's
  bool labels = false;                  // values are names of things, each with its colour
  // Both ask for labels. A table of ITK-SNAP's or 3D Slicer's kind: labels that it does not name do
  // not show. Looks of single labels come after it, one after another.
  std::string label_table = {};
  std::vector<Label> label_looks = {};
  std::string map = {};  // name of a colour map, "viridis"; empty: chosen
  // Colours span these; descending: reversed. The ramp of `threshold` ends at the greater one.
  // Unset: the range of the values; with `threshold` the part from there on.
  std::optional<std::array<double, 2>> range = {};
  // Channels that are not named look as the file says (OME), or by a colour of their own.
  std::vector<Channel> channels = {};
  // Unset: a second volume (VolumeOptions::over) is blended with a first one of one channel if both
  // can be blended, and all others are added.
  std::optional<Combine> combine = {};
  Light light = Light::kChosen;  // lights surfaces in composite mode; chosen: if it shows more
  // Attenuated maximum: a voxel length of the finest spacing at the greatest value of `range` dims
  // what is behind it by exp(-attenuation), and lesser values in proportion; unset: 0.05.
  std::optional<double> attenuation = {};
  // The opacity times a ramp of the gradient's magnitude, which is 1 from this share of the values'
  // range a voxel length on, above 0; unset: no ramp.
  std::optional<double> full_gradient = {};
  static constexpr double kUsualFullGradient = 0.1;  // what commands take for a ramp
  friend bool operator==(const LookOptions&, const LookOptions&) = default;
};

// The camera. World space is the volume's: voxel (0, 0, 0) at its origin.
struct ViewOptions {
  // The direction from which azimuth and elevation are counted. kPlain: along -z, y up, whatever
  // the axes mean; the others follow the meaning that the file gives its axes.
  enum class From { kPlain, kFront, kBack, kLeft, kRight, kTop, kBottom, kThreeQuarter };
  enum class Projection { kParallel, kPerspective };
  // The fit at zoom 1: the visible part (for a series, of all its steps, but see
  // VolumeOptions::whole_series), or the sphere around the volume.
  enum class Fit { kVisible, kVolume };
  // Replaces From, angles and Fit: world positions, eye and target apart.
  struct LookAt {
    std::array<double, 3> eye;
    std::array<double, 3> target;
    friend bool operator==(const LookAt&, const LookAt&) = default;
  };
  // A fit that pictures share, see Renderer::fit().
  struct Framing {
    std::array<double, 3> target;  // world
    // Parallel: half the picture's height in world units; perspective: from the eye to the target.
    double reach = 1;
    // The target's place right of and above the middle of the picture, in halves of its width and
    // height.
    double right = 0, up = 0;
    friend bool operator==(const Framing&, const Framing&) = default;
  };

  From from = From::kThreeQuarter;
  double azimuth_deg = 0;    // about the up axis, to the viewer's right
  double elevation_deg = 0;  // lifts the camera
  double zoom = 1;           // 1e-6 to 1e6
  Projection projection = Projection::kParallel;
  double field_of_view_deg = 30;                 // vertical, of perspective; in (0, 180)
  std::optional<std::array<double, 3>> up = {};  // world direction; unset: from `from`
  std::optional<Fit> fit = {};                   // unset: kVisible, and with kPlain kVolume
  std::optional<LookAt> look_at = {};
  std::optional<Framing> framing = {};  // in place of `fit`
  friend bool operator==(const ViewOptions&, const ViewOptions&) = default;
};

// A picture of a Renderer's volume and look.
struct PictureOptions {
  // Voxels, half-open: the part between the box's outer voxel planes is shown. One plane along an
  // axis is shown one voxel thick, with its own values all through.
  struct Box {
    std::array<int64_t, 3> lo;
    std::array<int64_t, 3> hi;
    friend bool operator==(const Box&, const Box&) = default;
  };
  // World positions p with dot(normal, p) <= offset show.
  struct Plane {
    std::array<double, 3> normal;
    double offset = 0;
    friend bool operator==(const Plane&, const Plane&) = default;
  };

  // How a ray is sampled in composite mode. kPlain: a sample shows its own value. The others: a
  // sample shows all values between it and the next ones (pre-integration), so that thin surfaces
  // and sharp edges have no rings, at the chosen step, twice that, or half of it. Labels, pictures
  // from coarser levels and steps of more than two voxels are plain always.
  enum class Quality { kPlain, kFast, kNormal, kHigh };

  // The light of a lit picture; what is not set has its default.
  struct Lighting {
    // The direction from which the key light comes, seen from the camera: degrees to the viewer's
    // right and upwards.
    std::optional<std::array<double, 2>> key = {};
    // Shares of a colour that all light reflects, and light on a surface that faces it; and of
    // white in a highlight. Each from 0 to 1.
    std::optional<double> ambient = {}, diffuse = {}, specular = {};
    // The share of the key light that matter on its way takes away, and the share of all other
    // light that matter around a place does; each from 0 to 1, unset: 0. Not for opacities that
    // depend on gradients. Above 0 they are refused in other modes than composite, and with
    // Light::kOff.
    std::optional<double> shadows = {}, occlusion = {};
    // The share by which colours at the farthest part of what the look shows are darkened, in
    // proportion to the depth behind the nearest part; from 0 to 1, unset: 0. Composite mode, lit
    // or not.
    std::optional<double> depth_cueing = {};
    friend bool operator==(const Lighting&, const Lighting&) = default;
  };

  int width = 512, height = 512;  // pixels, each at least 1
  ViewOptions view = {};
  int64_t time = 0;  // step of a series, from 0
  // Distance between samples along a ray, in voxel lengths of the finest spacing, above 0; unset:
  // 1/2 if pixels are smaller than voxels, otherwise 1.
  std::optional<double> step_vox = {};
  Quality quality = Quality::kPlain;
  // The share of the distance between samples over which the samples of neighbouring rays are
  // spread, by blue noise, from 0 to 1: fine grain in place of rings. Composite mode; unset: 0.
  std::optional<double> jitter = {};
  Lighting lighting = {};
  // Volumes with levels of resolution that have spreads, in composite mode and not of labels: each
  // part is drawn at the coarsest level whose voxels are at most this many pixels wide, above 0, as
  // far as three eighths of the memory hold the blocks. `level`: all at this level; 0 is the data
  // as stored, the only level of other volumes and modes.
  double pixel_error = 1;
  std::optional<int> level = {};
  // Refines levels until the blocks of the picture would exceed this many bytes as they are stored;
  // 0: no limit.
  uint64_t max_bytes = 0;
  // Refines parts where level 0 shows something thinner than two coarse voxels.
  bool keep_thin = false;
  std::optional<Box> crop = {};
  std::vector<Plane> clip_planes = {};  // at most 6
  bool with_depth = false;              // composite mode
  // The opacity at which a ray ends and hides what is behind, above 0, up to 1; 1 changes no
  // picture. Unset: 1, with PipelineOptions::occlusion 0.95.
  std::optional<double> opacity_threshold = {};
  // How long the picture may wait for data that is not in memory. Unset: waits for all data. A
  // volume of one level: data still missing then is left out of the picture (Image::missing_share),
  // and reading goes on for the next one. A volume with levels of resolution: the picture is whole,
  // and coarser where data would come later (Image::will_improve). With limits of 0.1 s or more,
  // pictures drawn one after the other until one will not improve begin coarse and end as the one
  // without a limit. Shorter limits are for views in motion: parts stay as fine as the last picture
  // had them, or a little longer, so that nothing flickers.
  std::optional<double> time_limit_s = {};
  // The step that the next picture will show. Its data is read once this picture's is there, as far
  // as there is room.
  std::optional<int64_t> next_time = {};
  friend bool operator==(const PictureOptions&, const PictureOptions&) = default;
};

// A slice of voxels: the plane `at` of an axis (0: x, 1: y, 2: z).
struct SliceOptions {
  int axis = 2;
  int64_t at = 0;
  int64_t time = 0;
  int most = 1024;  // values along a side: of more voxels every second, third, ... is taken
};

// How pictures are made, for those who study or measure it: each way gives the same picture, except
// that `occlusion` may leave out what an opacity_threshold below 1 hides. Words as `sluice render`
// takes them; empty: its default.
struct PipelineOptions {
  std::string algorithm = {};  // trims and merges blocks (Tong 1999): "conventional" (I),
                               // "clipped", "trimmed", "merged" (IV)
  std::string merge = {};      // the order in which blocks merge: "paper", "first-fit"
  // Draws the object boxes of "blocks", or their visible growing "boxes" (Li 2003), always of the
  // finest level.
  std::string partition = {};
  // Composite mode: skips what is hidden: "off", "map", "cull", "clip" (Li 2003).
  std::string occlusion = {};
  std::string policy = {};            // of the texture cache: "lru", "arc", ...
  uint64_t seed = 1;                  // of the policy "random"
  std::optional<int64_t> pages = {};  // of the texture cache, a power of two; unset: by memory
  std::string simd = {};              // the best instructions that the CPU may use: "avx2", ...
  std::string gl = {};                // the library for OpenGL contexts: "osmesa", "egl"
};

// Resources that drawing may take.
struct RendererOptions {
  // kGl: OpenGL on a GPU, or by Mesa's software renderer. kAuto: a GPU if there is one, else the
  // CPU.
  enum class Device { kAuto, kGl, kCpu };
  Device device = Device::kAuto;
  // A hard bound on the voxels in memory at once, with software GL its textures too; 0: half of the
  // machine's.
  uint64_t memory_bytes = 0;
  int threads = 0;  // to classify and, on the CPU, draw; at least as many read; 0: one a core
  // Unless the CPU draws: the context to draw in, for Renderer::drawOnScreen().
  std::shared_ptr<const ScreenContext> screen = {};
  PipelineOptions pipeline = {};
  // Width and height of the largest picture for Renderer::drawToFile() and drawRows(): memory_bytes
  // then bounds the drawing and writing of such pictures, too. 0: pictures come on top.
  int rows_width = 0, rows_height = 0;
};

}  // namespace sluice
