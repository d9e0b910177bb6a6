// Surfaces made of a volume in memory, as the tests of them and of their files begin with.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "src/surface/surface.h"
#include "tests/support/temp_folder.h"
#include "tests/surface/mesh_checks.h"

namespace sluice::surface_test {

struct Options {
  double threshold = 0;
  int64_t block = 16;
  int threads = 2;
  uint64_t memory_bytes = UINT64_MAX;
  bool is_closed = false;
  std::optional<Box3> cells = {};
  MeshFormat format = MeshFormat::kPly;
  StopToken stop = {};
  CheckBlock check = {};
};

struct Made {
  SurfaceReport report;
  std::string bytes;  // of the file
  Mesh mesh;          // of a PLY
};

// The min-max arrays are made from `source`, the surface from `read`.
inline Made makeFrom(VolumeSource& source, VolumeSource& read, const Options& options) {
  const TempFolder folder;
  WorkerPool pool(options.threads);
  ProgressMeter progress;
  const VolumeLayout& layout = source.layout();
  const SliceRanges ranges =
      buildSliceRanges(source, 0, blockLayout(layout.dims, options.block, 1), {pool, progress});
  const InsideSet inside = insideSet(deviceMap(layout), options.threshold);
  const SurfaceRegion region{options.cells.value_or(boxOf(layout.dims - Vec3i{1, 1, 1})),
                             options.is_closed};
  const SurfaceRequest request{
      .source = read,
      .time = 0,
      .inside = inside,
      .place = surfacePlace(layout, {}),
      .region = region,
      .states = blockStates(ranges, inside, options.is_closed ? &region.cells : nullptr),
      .check = options.check,
      .memory_bytes = options.memory_bytes,
      .stop = options.stop};
  const auto path = folder / "mesh";
  Made made;
  {
    MeshFile file(path, options.format, "a test");
    made.report = makeSurface(request, file, pool, progress);
    file.commit();
  }
  made.bytes = readFile(path);
  if (options.format == MeshFormat::kPly) made.mesh = readPly(path);
  return made;
}
inline Made make(VolumeSource& source, const Options& options) {
  return makeFrom(source, source, options);
}

}  // namespace sluice::surface_test
