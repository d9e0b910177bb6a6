#include "tests/support/ball_pyramid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/temp_folder.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

std::string shapeOf(Vec3i v, int time_steps, int64_t of_time) {
  const std::string space = fmt::format("{}, {}, {}", v.z, v.y, v.x);
  return time_steps > 1 ? fmt::format("[{}, {}]", of_time, space) : "[" + space + "]";
}

// The bytes of a chunk, whose voxels are `scale` finest ones apart; empty: all are 0.
std::string chunkBytes(const BallPyramid& ball, Vec3i corner, double scale, int64_t time) {
  std::string bytes;
  bool is_empty = true;
  const double shift = (scale - 1) / 2;
  for (int64_t z = 0; z < ball.chunk; ++z)
    for (int64_t y = 0; y < ball.chunk; ++y)
      for (int64_t x = 0; x < ball.chunk; ++x) {
        const Vec3d at = toDouble(corner + Vec3i{x, y, z}) * scale + Vec3d{shift, shift, shift};
        const auto value = static_cast<uint8_t>(std::lround(ball.valueAt(at, time)));
        is_empty = is_empty && value == 0;
        bytes.push_back(static_cast<char>(value));
      }
  return is_empty ? "" : bytes;
}

void writeLevel(const BallPyramid& ball, const fs::path& folder, int level) {
  const auto scale = static_cast<double>(1 << level);
  const int64_t side = int64_t{1} << level;
  const Vec3i dims = (ball.dims + Vec3i{side - 1, side - 1, side - 1}) / side;
  fs::create_directories(folder);
  const std::string shape = shapeOf(dims, ball.time_steps, ball.time_steps);
  const std::string chunks = shapeOf({ball.chunk, ball.chunk, ball.chunk}, ball.time_steps, 1);
  writeFile(folder / ".zarray",
            R"({"zarr_format": 2, "shape": )" + shape + R"(, "chunks": )" + chunks +
                R"(, "dtype": "|u1", "fill_value": 0, "order": "C", "filters": null, )"
                R"("dimension_separator": ".", "compressor": null})");
  for (int64_t time = 0; time < ball.time_steps; ++time) {
    const Vec3d middle = ball.middle + Vec3d{static_cast<double>(time) * ball.radius, 0, 0};
    Box3 touched;
    for (int a = 0; a < 3; ++a) {
      const double lo = (middle[a] - ball.radius) / scale - 1;
      const double hi = (middle[a] + ball.radius) / scale + 1;
      touched.lo[a] = std::max<int64_t>(0, static_cast<int64_t>(lo)) / ball.chunk;
      touched.hi[a] = std::min(dims[a] - 1, static_cast<int64_t>(hi)) / ball.chunk + 1;
    }
    for (int64_t z = touched.lo.z; z < touched.hi.z; ++z)
      for (int64_t y = touched.lo.y; y < touched.hi.y; ++y)
        for (int64_t x = touched.lo.x; x < touched.hi.x; ++x) {
          const std::string bytes = chunkBytes(ball, Vec3i{x, y, z} * ball.chunk, scale, time);
          const std::string of_time = ball.time_steps > 1 ? fmt::format("{}.", time) : "";
          if (!bytes.empty())
            writeFile(folder / fmt::format("{}{}.{}.{}", of_time, z, y, x), bytes);
        }
  }
}

}  // namespace

double BallPyramid::valueAt(Vec3d finest, int64_t time) const {
  const Vec3d from = finest - middle - Vec3d{static_cast<double>(time) * radius, 0, 0};
  const double share = length(from) / radius;
  return share >= 1 ? 0 : 240 - 160 * share;
}

void BallPyramid::write(const fs::path& folder) const {
  std::string datasets;
  const bool has_time = time_steps > 1;
  for (int level = 0; level < levels; ++level) {
    writeLevel(*this, folder / std::to_string(level), level);
    const int scale = 1 << level;
    const double shift = (scale - 1) / 2.0;
    datasets += fmt::format(
        R"({}{{"path": "{}", "coordinateTransformations": [{{"type": "scale", "scale": )"
        R"([{}{}, {}, {}]}}, {{"type": "translation", "translation": [{}{}, {}, {}]}}]}})",
        level == 0 ? "" : ", ", level, has_time ? "1, " : "", scale, scale, scale,
        has_time ? "0, " : "", shift, shift, shift);
  }
  const std::string time_axis = has_time ? R"({"name": "t", "type": "time"}, )" : "";
  writeFile(folder / ".zgroup", R"({"zarr_format": 2})");
  writeFile(folder / ".zattrs",
            R"({"multiscales": [{"version": "0.4", "axes": [)" + time_axis +
                R"({"name": "z", "type": "space"}, {"name": "y", "type": "space"}, )"
                R"({"name": "x", "type": "space"}], "datasets": [)" +
                datasets + "]}]}");
}

void spoilLevel(const fs::path& pyramid, int level) {
  for (const auto& file : fs::directory_iterator(pyramid / std::to_string(level)))
    if (file.path().filename().string().front() != '.') writeFile(file.path(), "spoilt");
}

}  // namespace sluice
