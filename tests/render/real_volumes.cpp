#include "tests/render/real_volumes.h"

#include <ostream>

#include "io/open_volume.h"
#include "src/classify/transfer/automatic_look.h"
#include "src/render/camera/index_space.h"

namespace sluice {
namespace {

constexpr RealVolume kVolumes[] = {
    {"bonsai", "bonsai.nii.gz"},
    {"engine", "engine.nii.gz"},
    {"engine_raw", "engine_256x256x128_uint8.raw"},
    {"visible_female_head", "visible-female-head"},
    // Two series in one folder.
    {"cthead", "cthead/%03d.tif", {1, 1, 2}},
    {"cthead_8bit", "cthead/cthead-8bit%03d.tif", {1, 1, 2}},
    {"head_mr", "head-mr.nii.gz"},
    {"motor_map", "motor-map.nii.gz"},
    {"tooth", "tooth/tooth.nhdr"},
    {"headsq_quarter", "headsq-quarter/quarter.nhdr"},
    {"head_mr_volume", "HeadMRVolume.mhd"},
    {"nucleon", "nucleon.nrrd"},
    {"walnut", "walnut_128x96x114_uint16.raw"},
    {"smoke", "smoke.vdb"},
    {"cube", "cube.vdb"},
    {"sphere", "sphere.vdb"},
    {"viscous_fingers", "viscous-fingers/step_%03d.nrrd", {0, 0, 0}, 19},
};

}  // namespace

void PrintTo(const RealVolume& volume, std::ostream* out) {
  *out << volume.input;
}

std::span<const RealVolume> realVolumes() {
  return kVolumes;
}

std::filesystem::path realVolumesFolder() {
  return SLUICE_DATA_DIR;
}

std::unique_ptr<VolumeSource> openReal(const RealVolume& volume) {
  const std::filesystem::path path = realVolumesFolder() / volume.input;
  const bool is_pattern = path.string().find('%') != std::string::npos;
  if (!std::filesystem::exists(is_pattern ? path.parent_path() : path)) return nullptr;
  OpenOptions open;
  if (volume.spacing.x > 0) open.spacing = volume.spacing;
  return openVolume(path.string(), open);
}

TransferFunction automaticFor(const SliceRanges& ranges, const VolumeLayout& layout) {
  AutomaticOptions options;
  options.thickness_vox = 100;
  options.signed_distance = layout.name.ends_with("(level set)");
  options.finest_spacing = finestSpacing(layout);
  return automaticLook(scaled(ranges.counts, ranges.map.scale, ranges.map.offset), options)
      .transfer;
}

}  // namespace sluice
