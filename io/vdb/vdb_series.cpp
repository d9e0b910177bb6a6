#include "io/vdb/vdb_series.h"

#include <array>
#include <cmath>
#include <optional>

#include "io/vdb/vdb_header.h"
#include "io/vdb/vdb_reader.h"
#include "io/vdb/vdb_source.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// world = origin + sum over axes of steps[a] * index[a]
struct Place {
  std::array<Vec3d, 3> steps{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vec3d origin;
};

Vec3d vectorOf(VdbReader& reader) {
  const auto x = reader.number<double>(), y = reader.number<double>(), z = reader.number<double>();
  return {x, y, z};
}

// A grid's transform out of its file, in the kinds that OpenVDB writes for affine ones.
Place readPlace(File& file, const VdbGridInfo& info) {
  VdbReader reader(file);
  reader.seek(info.transform_at);
  const std::string type = reader.text();
  Place place;
  if (type == "AffineMap" || type == "UnitaryMap") {
    for (int row = 0; row < 4; ++row) {
      const Vec3d values = vectorOf(reader);
      reader.number<double>();
      (row < 3 ? place.steps[static_cast<size_t>(row)] : place.origin) = values;
    }
    return place;
  }
  const bool moves = type == "TranslationMap" || type.ends_with("TranslateMap");
  if (moves) place.origin = vectorOf(reader);
  if (type != "TranslationMap" && type.find("Scale") != std::string::npos) {
    const Vec3d scale = vectorOf(reader);
    for (int a = 0; a < 3; ++a) {
      Vec3d& step = place.steps[static_cast<size_t>(a)];
      step = step * scale[a];
    }
  } else if (type != "TranslationMap") {
    fail("{}: grid \"{}\" has a \"{}\" transform, expected an affine one; resample it first",
         file.path(), info.name, type.substr(0, 40));
  }
  return place;
}

// The index, a fraction perhaps, of a point of the world.
Vec3d indexOf(const Place& place, Vec3d world) {
  const auto& [x, y, z] = place.steps;
  const Vec3d from = world - place.origin;
  const double all = dot(cross(x, y), z);
  return Vec3d{dot(cross(y, z), from), dot(cross(z, x), from), dot(cross(x, y), from)} / all;
}

struct Step {
  Place place;
  Box3 active;  // may be empty
};

Step readStep(const std::filesystem::path& path, const std::string& grid) {
  File file(path);
  const VdbGridInfo info = chooseVdbGrid(file.path(), readVdbGrids(file), grid);
  Step step{readPlace(file, info), {}};
  if (info.active) {
    step.active = *info.active;
    return step;
  }
  // Metadata need not state a box: only the tree tells it then.
  const VolumeLayout layout = openVdb(path, grid)->layout();
  const Vec3d lo = indexOf(step.place, layout.origin);
  const Vec3i first{std::llround(lo.x), std::llround(lo.y), std::llround(lo.z)};
  // openVdb() adds a layer of background on each side.
  step.active = {first + Vec3i{1, 1, 1}, first + layout.dims - Vec3i{1, 1, 1}};
  return step;
}

// The shift from an index of the first step to that of the same voxel in another step.
Vec3i shiftBetween(const std::filesystem::path& path, const Place& first, const Place& other) {
  constexpr double kSame = 1e-6, kMostVoxels = 1e9;
  bool agrees = true;
  for (size_t a = 0; a < 3; ++a)
    agrees = agrees && length(other.steps[a] - first.steps[a]) <= kSame * length(first.steps[a]);
  const Vec3d shift = indexOf(other, first.origin);
  Vec3i whole;
  for (int a = 0; a < 3; ++a) {
    agrees = agrees && std::abs(shift[a]) < kMostVoxels;
    whole[a] = agrees ? std::llround(shift[a]) : 0;
    agrees = agrees && std::abs(shift[a] - static_cast<double>(whole[a])) < 1e-3;
  }
  if (!agrees)
    fail(
        "{}: its voxels lie between the voxels of the first step or have another size; resample it "
        "first, since all steps of a series need the same voxel grid",
        path.string());
  return whole;
}

}  // namespace

std::vector<Box3> vdbSeriesBoxes(const std::vector<std::filesystem::path>& files,
                                 const std::string& grid, const StopToken& stop) {
  std::optional<Place> first;
  std::vector<Vec3i> shifts;
  Box3 all;
  for (const auto& file : files) {
    stop.throwIfStopped();
    const Step step = readStep(file, grid);
    if (!first) first = step.place;
    shifts.push_back(shiftBetween(file, *first, step.place));
    if (step.active.empty()) continue;
    const Box3 box = translate(step.active, -shifts.back());
    all = all.empty() ? box : unite(all, box);
  }
  if (all.empty())
    fail("{}: no active voxels in any of the {} steps: nothing to show", files[0].string(),
         files.size());
  // A layer of background around all steps, as a single grid has.
  const Box3 padded{all.lo - Vec3i{1, 1, 1}, all.hi + Vec3i{1, 1, 1}};
  std::vector<Box3> boxes;
  boxes.reserve(shifts.size());
  for (const Vec3i& shift : shifts) boxes.push_back(translate(padded, shift));
  return boxes;
}

}  // namespace sluice
