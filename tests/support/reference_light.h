// The light that arrives at places of a volume, for the reference renderer: what
// src/render/light/light_sweep.h and arriving_light.h define, in plain double-precision loops over
// the voxels and nothing of the renderer.
#pragma once

#include <array>
#include <vector>

#include "src/base/sources/volume_source.h"
#include "src/render/camera/camera.h"
#include "tests/support/reference_renderer.h"
#include "tests/support/reference_values.h"

namespace sluice {

class ReferenceLight {
 public:
  // Without a light that looks around, all light arrives.
  ReferenceLight(const VolumeLayout& layout, const View& view, const ReferenceScene& scene,
                 const ReferenceValues& values);

  // The shares of the key light and of all other light at an index position.
  std::array<double, 2> at(Vec3d index) const;

 private:
  double& texel(std::vector<double>& of, Vec3i at) const;
  double texelOr1(const std::vector<double>& of, Vec3i at) const;
  void measure(const ReferenceScene& scene, const ReferenceValues& values);
  double extinctionOf(const ReferenceScene& scene, const ReferenceValues& values,
                      Vec3i voxel) const;
  double shownShare(const ReferenceScene& scene, Vec3d index) const;
  // The share of light that arrives at each texel from a direction of the world.
  std::vector<double> arriving(Vec3d toward, double reach_vox) const;

  const VolumeLayout& layout_;
  double finest_ = 1, longest_ = 0;
  Vec3i grid_, voxels_{1, 1, 1};
  std::vector<double> extinction_, key_, open_;  // empty: all light arrives
};

}  // namespace sluice
