// The surface of an indexed volume, or of a coarser level of it, as a mesh (src/surface/surface.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/library/opening/indexed_volume.h"
#include "src/surface/surface.h"

namespace sluice {

struct SurfaceOptions {
  double threshold = 0;  // in values of the file, rescaled
  int64_t level = 0;     // of resolution
  // Voxels of level 0; the part between its outer voxel planes. Unset: all.
  std::optional<Box3> crop;
  bool is_closed = false;  // along the border, too
};

// An IndexedVolume for a surface is opened with these needs.
IndexNeeds surfaceNeeds(const SurfaceOptions& options);

struct VolumeSurface {
  SurfaceReport report;
  Vec3i dims;  // voxels of the level
  // Lines for people: the mesh is empty, or floats cannot tell its positions apart.
  std::vector<std::string> warnings;
};

// Writes the mesh into `file`, which the caller commits. Throws Error, Interrupted.
VolumeSurface makeSurface(const IndexedVolume& volume, const SurfaceOptions& options,
                          MeshFile& file, const IndexPass& pass);

}  // namespace sluice
