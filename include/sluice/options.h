// What a picture shows and how: plain data, with the defaults of `sluice render`.
#pragma once

#include <sluice/screen.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sluice {

// How values look. The first of these that is said makes the opacities: opacities, transfer_file,
// labels, threshold. Otherwise they are chosen from the values. Opacities beside a transfer_file
// have the colours of that file.
struct LookOptions {
  enum class Mode { kComposite, kMaximum, kMinimum, kAverage };
  enum class Light { kChosen, kOn, kOff };
  struct Opacity {
    double value = 0;
    double opacity = 0;  // 0 to 1, of one voxel length of the finest spacing
    friend bool operator==(const Opacity&, const Opacity&) = default;
  };

  Mode mode = Mode::kComposite;
  // A ramp: opacity 0 below it, a fifth of `opacity` at it, and that at the top of the values.
  std::optional<double> threshold = {};
  std::optional<double> opacity = {};   // at the top; unset: 0.05, or what is chosen
  std::vector<Opacity> opacities = {};  // ascending by value, linear in between
  std::string transfer_file = {};       // our JSON, or ParaView's
  bool labels = false;                  // values are names of things, each with its colour
  std::string map = {};                 // of colours, "viridis"; empty: chosen
  std::optional<std::array<double, 2>> range = {};  // that colours span; descending: turned round
  Light light = Light::kChosen;  // of surfaces, in composite mode; chosen: where it shows more
  // The opacity times a ramp of the gradient's magnitude, which is 1 from this share of the values'
  // range a voxel length on, above 0; unset: no ramp.
  std::optional<double> full_gradient = {};
  friend bool operator==(const LookOptions&, const LookOptions&) = default;
};

// Where the volume is looked at from. World space is the volume's: voxel (0, 0, 0) at its origin.
struct ViewOptions {
  // Where azimuth and elevation start. kPlain: along -z, y up, whatever the axes mean; the others
  // are those of what the file says of its axes.
  enum class From { kPlain, kFront, kBack, kLeft, kRight, kTop, kBottom, kThreeQuarter };
  enum class Projection { kParallel, kPerspective };
  // What zoom 1 shows whole: what is visible, of a series in any of its steps (but see
  // VolumeOptions::whole_series), or the sphere around the volume.
  enum class Fit { kVisible, kVolume };
  // In place of From, angles and Fit: world positions, eye and target apart.
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
    // Where the target lies: to the right of and above the middle, of half the width and height.
    double right = 0, up = 0;
    friend bool operator==(const Framing&, const Framing&) = default;
  };

  From from = From::kThreeQuarter;
  double azimuth_deg = 0;    // about what is up, to the viewer's right
  double elevation_deg = 0;  // lifts the camera
  double zoom = 1;           // above 0
  Projection projection = Projection::kParallel;
  double field_of_view_deg = 30;                 // vertical, of perspective; in (0, 180)
  std::optional<std::array<double, 3>> up = {};  // world direction; unset: that of `from`
  std::optional<Fit> fit = {};                   // unset: kVisible, and with kPlain kVolume
  std::optional<LookAt> look_at = {};
  std::optional<Framing> framing = {};  // in place of `fit`
  friend bool operator==(const ViewOptions&, const ViewOptions&) = default;
};

// A picture of a Renderer's volume and look.
struct PictureOptions {
  // Voxels, half-open: what lies between its outer voxel planes is shown.
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

  int width = 512, height = 512;  // pixels, each at least 1
  ViewOptions view = {};
  int64_t time = 0;  // step of a series, from 0
  // Between samples along a ray, in voxel lengths of the finest spacing, above 0; unset: 1/2 where
  // pixels are smaller than voxels, otherwise 1.
  std::optional<double> step_vox = {};
  std::optional<Box> crop = {};
  std::vector<Plane> clip_planes = {};  // at most 6
  bool with_depth = false;              // composite mode
  // How long it may wait for what is not in memory. What is missing then is left out of the picture
  // (Image::missing_share), and is read on meanwhile for the next one. Unset: all is waited for.
  std::optional<double> time_limit_s = {};
  // The step that the picture after this one will show: what it needs is read once this one has
  // what it needs, as far as there is room.
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

// What drawing may take.
struct RendererOptions {
  // kGl: OpenGL on a GPU, or by Mesa's software renderer. kAuto: a GPU where there is one, else the
  // CPU.
  enum class Device { kAuto, kGl, kCpu };
  Device device = Device::kAuto;
  // A hard bound on the voxels in memory at once, with software GL its textures too; 0: half of the
  // machine's.
  uint64_t memory_bytes = 0;
  int threads = 0;  // that classify and, on the CPU, draw; as many and more read; 0: one a core
  // Where it is not the CPU that draws: drawn in here, for Renderer::drawOnScreen().
  std::shared_ptr<const ScreenContext> screen = {};
};

}  // namespace sluice
