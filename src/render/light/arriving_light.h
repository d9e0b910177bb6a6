// ArrivingLight: the LightVolume of a frame, and what several frames share of it.
//
//   TimeStep, Look -> CoarseExtinction -> what of it shows -> ambient light
//                                                        \-> key light, for each view
//
// Matter that is cropped or clipped away casts no shadow. The ambient light of a place is the mean
// of kAmbientDirections sweeps whose shadows end, times 2 and at most 1: a flat surface sees half
// of the directions and counts as open. One thread; sweeps run on all threads of the pool.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "src/device/shading/light_volume.h"
#include "src/render/blocks/memo.h"
#include "src/render/camera/camera.h"
#include "src/render/camera/frame_options.h"
#include "src/render/light/coarse_extinction.h"

namespace sluice {

inline constexpr int kAmbientDirections = 14;
// After this share of the volume's longest side a shadow of ambient light is 1/e of what it was.
inline constexpr double kAmbientReach = 1.0 / 8;

class ArrivingLight {
 public:
  // Null if the lighting asks for neither shadows nor occlusion. Throws as coarseExtinction() does.
  LightVolumePtr of(const TimeStep& step, const LookPtr& look, MatterFrom from, const View& view,
                    const FrameOptions& options, WorkerPool& pool);

 private:
  struct MatterKey {
    VolumeSource* source;
    int64_t time;
    Identity<Look> look;
    VoxelPlanes planes;
    friend bool operator==(const MatterKey&, const MatterKey&) = default;
  };
  struct ShownKey {
    Identity<CoarseExtinction> matter;
    std::vector<ClipPlane> shown;
    friend bool operator==(const ShownKey&, const ShownKey&) = default;
  };
  using Numbers = std::vector<float>;
  struct LightKey {
    Identity<CoarseExtinction> matter;
    Vec3d toward;  // of the key light, in texels; 0 if it casts no shadows
    double shadows, occlusion;
    friend bool operator==(const LightKey&, const LightKey&) = default;
  };

  // One for the finest voxels and one for levels: previews alternate with pictures of level 0.
  std::array<Memo<MatterKey, const CoarseExtinction>, 2> matter_;
  Memo<ShownKey, const CoarseExtinction> shown_;
  Memo<Identity<CoarseExtinction>, const Numbers> ambient_;
  Memo<LightKey, const LightVolume> light_;
};

// The memory that it takes for a volume while a frame is made and drawn, on a device that copies
// the light volume or not.
uint64_t lightBytes(const VolumeLayout& layout, int threads);

}  // namespace sluice
