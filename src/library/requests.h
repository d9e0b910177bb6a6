// Requests to the library, with the defaults: which volume, how it looks, which resources drawing
// may take. Plain data. The public headers have options of their own (include/sluice), which are
// converted to these; commands fill these directly.
#pragma once

#include <sluice/options.h>
#include <sluice/volume.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cache/policies/policy.h"
#include "io/open_volume.h"
#include "src/base/looks/channel_look.h"
#include "src/base/looks/label_look.h"
#include "src/base/looks/surface_look.h"
#include "src/base/threads/stop_token.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/library/drawing/scene/device_choice.h"

namespace sluice {

// The volume, and how to read it if the file does not tell.
struct VolumeArguments {
  std::vector<std::string> inputs;
  OpenOptions open = {};
  int64_t time = 0;
  VolumeOptions asked = {};  // as the user gives them; `open` follows from them, see setOpen()
};

// How the pictures of several channels become one.
enum class Combine { kAdd, kBlend };

// How it looks.
struct LookArguments {
  std::optional<double> threshold;
  std::string transfer_file;
  std::string map;
  std::optional<double> opacity;
  std::vector<OpacityPoint> opacities;  // empty: from one of the others
  std::vector<ChannelLook> channels;    // looks of single channels
  std::optional<Combine> combine;       // unset: see combineOf()
  std::vector<SurfaceLook> surfaces;    // drawn alone unless opacities are given
  bool labels = false;                  // as a table or a look of a label ask for, too
  std::string label_table;              // a file
  std::vector<LabelLook> label_looks;
  std::optional<ValueRange> range;  // in place of the data's; lo > hi turns a map round
  // For a series: look and fit follow from the drawn step alone.
  bool this_step = false;
  // Steps are drawn one after another: the range of values covers all.
  bool whole_series = false;
  bool shade = false, no_shade = false;
  // For people who give no options: lit if that shows more, one look for a whole series, chosen
  // from the values. Benches stay plain: unlit, and a ramp from plainThreshold() on.
  bool first_picture = false;
  bool modulate = false;  // the opacity by the gradient's magnitude
  // The gradient of factor 1: a share of the value range per voxel length.
  double full_gradient = LookOptions::kUsualFullGradient;
  double attenuation = kDefaultAttenuation;  // of the attenuated maximum
  StopToken stop = {};                       // ends waiting for a transfer file that is a pipe
};

// The fit at zoom 1: the visible part of the volume, or the sphere around the volume. Unset: the
// plain view has the sphere, all others what is visible.
enum class Fit { kVisible, kVolume };
using FitChoice = std::optional<Fit>;

// Whether coarser levels are made, once, for a volume whose file has none (side_levels.h): if it is
// large; whatever its size; not now, but those made before are used; or never, and those are not
// used either.
enum class LevelsWish { kAuto, kAlways, kKept, kNone };

// Limits of MachineOptions; blocks and pages are powers of two.
inline constexpr int kMostThreads = 1024;
inline constexpr int64_t kMostCachePages = int64_t{1} << 31;
inline constexpr int64_t kLeastBlock = 4, kMostBlock = 1024;  // a page's side is at most a block's

// Resources that drawing may take.
struct MachineOptions {
  uint64_t memory_bytes = 0;  // 0: half of the machine's memory
  int threads = 0;            // 0: one a core
  DeviceArguments device;
  std::optional<Vec3i> page_vox;
  std::optional<int64_t> pages;
  std::optional<int64_t> block;
  LevelsWish levels = LevelsWish::kAuto;
  PolicyKind policy = PolicyKind::kLru;
  uint64_t seed = 1;
};

}  // namespace sluice
