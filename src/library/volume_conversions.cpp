#include <bit>
#include <utility>

#include "io/lent_source.h"
#include "src/base/error.h"
#include "src/library/checked_values.h"
#include "src/library/conversions.h"

namespace sluice {
namespace {

VoxelType typeOf(const std::string& name, const std::string& type) {
  const std::optional<VoxelType> known = parseVoxelType(type);
  if (!known)
    failRequest(
        "{}: voxel type \"{}\" is not known, expected u8, i8, u16, i16, u32, i32, f32 or f64", name,
        type);
  return *known;
}

WebOptions webOptions(const VolumeOptions::Web& web) {
  WebOptions options;
  options.cache = {web.cache_folder, web.cache_folder.empty() ? 0 : web.cache_bytes};
  options.certificates = {web.certificate_file, web.certificate_folder};
  BucketAccess& buckets = options.buckets;
  buckets.endpoint = web.endpoint;
  if (!web.region.empty()) buckets.region = web.region;
  // A key without its secret signs nothing: a bucket is then asked as the public may.
  if (!web.secret_key.empty()) buckets.access_key = web.access_key;
  buckets.secret_key = web.secret_key;
  buckets.session_token = web.session_token;
  return options;
}

LevelsWish levelsWish(VolumeOptions::Levels levels) {
  switch (levels) {
    case VolumeOptions::Levels::kKept:
      return LevelsWish::kKept;
    case VolumeOptions::Levels::kAuto:
      return LevelsWish::kAuto;
    case VolumeOptions::Levels::kAlways:
      return LevelsWish::kAlways;
    case VolumeOptions::Levels::kNone:
      return LevelsWish::kNone;
  }
  failRequest("levels {}: no such wish", static_cast<int>(levels));
}

}  // namespace

void setOpen(VolumeArguments& arguments) {
  const VolumeOptions& options = arguments.asked;
  OpenOptions& open = arguments.open;
  if (options.dims) open.dims = vec(*options.dims);
  open.time_steps = options.time_steps;
  open.type = parseVoxelType(options.type);
  if (options.big_endian) open.byte_order = std::endian::big;
  open.skip_bytes = options.skip_bytes;
  if (options.spacing) open.spacing = vec(*options.spacing);
  open.grid = options.grid;
  open.channel = {options.channel, options.channel_name};
}

VolumeArguments volumeArguments(const std::vector<std::string>& paths,
                                const VolumeOptions& options) {
  if (paths.empty()) failRequest("a volume of no files: name at least one");
  if (options.time_steps && !options.dims)
    failRequest("time_steps {}: describes a raw file together with dims, which is not given",
                *options.time_steps);
  VolumeArguments arguments{.inputs = paths, .time = options.time, .asked = options};
  setOpen(arguments);
  if (!options.type.empty()) arguments.open.type = typeOf(paths.front(), options.type);
  arguments.open.decode.folder = options.temporary_folder;
  arguments.open.web = webOptions(options.web);
  return arguments;
}

VolumeLayout volumeLayout(const ArrayLayout& array) {
  VolumeLayout layout;
  layout.name = array.name.empty() ? "array" : array.name;
  layout.dims = vec(array.dims);
  layout.time_steps = array.time_steps;
  layout.unit = array.unit;
  layout.type = typeOf(layout.name, array.type);
  std::array<Vec3d, 3> steps;
  for (size_t a = 0; a < 3; ++a) {
    const Vec3d axis = vec(array.axes[a]);
    // The negations refuse NaN, too.
    if (!(array.spacing[a] > 0) || !(length(axis) > 0))
      failRequest("{}: spacing {} along {}: must be above 0, and the axis must have a length",
                  layout.name, array.spacing[a], "xyz"[a]);
    steps[a] = axis * (array.spacing[a] / length(axis));
  }
  return lentLayout(std::move(layout), steps, vec(array.origin));
}

VolumeOptions::Web webAccess(const BucketAccess& buckets) {
  return {.access_key = buckets.access_key,
          .secret_key = buckets.secret_key,
          .session_token = buckets.session_token,
          .region = buckets.region,
          .endpoint = buckets.endpoint};
}

MachineOptions machineOptions(const VolumeOptions& options) {
  MachineOptions machine;
  machine.memory_bytes = options.memory_bytes;
  machine.threads = checkedThreads(options.threads);
  machine.levels = levelsWish(options.levels);
  machine.block = options.block;
  if (options.block) requirePowerOfTwo("block", *options.block, kLeastBlock, kMostBlock);
  if (options.page) {
    for (const int64_t side : *options.page) requirePowerOfTwo("page", side, 1, kMostBlock);
    machine.page_vox = vec(*options.page);
  }
  return machine;
}

void requireStep(int64_t time, const VolumeLayout& layout) {
  if (time < 0 || time >= layout.time_steps)
    failRequest("{}: time {}: the volume has {} time step{}, counted from 0", layout.name, time,
                layout.time_steps, layout.time_steps == 1 ? "" : "s");
}

std::string frameName(WorldFrame frame) {
  switch (frame) {
    case WorldFrame::kRas:
      return "RAS";
    case WorldFrame::kLps:
      return "LPS";
    case WorldFrame::kPictureRows:
      return "rows";
    case WorldFrame::kYUp:
      return "y-up";
    case WorldFrame::kNone:
      break;
  }
  return "";
}

VolumeInfo volumeInfo(const VolumeLayout& layout, ValueRange values,
                      const std::vector<std::string>& notes) {
  return {.name = layout.name,
          .dims = asArray(layout.dims),
          .type = std::string(name(layout.type)),
          .spacing = asArray(layout.spacing),
          .origin = asArray(layout.origin),
          .unit = layout.unit,
          .axes = {asArray(layout.axes[0]), asArray(layout.axes[1]), asArray(layout.axes[2])},
          .frame = frameName(layout.frame),
          .time_steps = layout.time_steps,
          .channels = {},
          .was_opened_soon = false,
          .value_range = {values.lo, values.hi},
          .warnings = notes,
          .files = {}};
}

}  // namespace sluice
