// A source with some properties replaced, its voxels as they are.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "src/base/sources/volume_source.h"

namespace sluice {

// With these distances between voxels, in world units; the source itself if they are its own or
// nullopt.
std::unique_ptr<VolumeSource> respaced(std::unique_ptr<VolumeSource> source,
                                       const std::optional<Vec3d>& spacing);

// The same voxels, the first one at `origin`, in world units.
std::unique_ptr<VolumeSource> placedAt(std::unique_ptr<VolumeSource> source, Vec3d origin);

// With one more note in its layout; nullopt: the source itself.
std::unique_ptr<VolumeSource> withNote(std::unique_ptr<VolumeSource> source,
                                       const std::optional<std::string>& note);

}  // namespace sluice
