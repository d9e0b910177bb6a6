// Small volumes of the kinds that people have, as raw files.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

namespace sluice {

inline constexpr int64_t kSide = 40;

// A number from -1 to 1 that is independent of its place.
inline double noise(int64_t x, int64_t y, int64_t z) {
  auto n = static_cast<uint32_t>(x * 73856093 ^ y * 19349663 ^ z * 83492791);
  n = (n ^ (n >> 13)) * 1274126177U;
  n ^= n >> 16;
  return static_cast<double>(n & 0xffffU) / 32768 - 1;
}
// The sum of four is nearly normal, of deviation 1.
inline double normalNoise(int64_t x, int64_t y, int64_t z) {
  double sum = 0;
  for (int64_t i = 0; i < 4; ++i) sum += noise(x + 101 * i, y + 53 * i, z + 17 * i);
  return sum / std::sqrt(4.0 / 3);
}

inline double fromCenter(int64_t x, int64_t y, int64_t z) {
  const double half = (kSide - 1) / 2.0;
  return std::hypot(static_cast<double>(x) - half, static_cast<double>(y) - half,
                    static_cast<double>(z) - half);
}

using Voxel = std::function<double(int64_t, int64_t, int64_t)>;

template <class T>
std::string rawBytes(const Voxel& voxel) {
  std::string bytes;
  for (int64_t z = 0; z < kSide; ++z)
    for (int64_t y = 0; y < kSide; ++y)
      for (int64_t x = 0; x < kSide; ++x) {
        const auto value = static_cast<T>(voxel(x, y, z));
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
      }
  return bytes;
}

// Kinds of volumes that people have, small. `name`: a part of the look's name.
struct Kind {
  std::string file, name, bytes;
};

// Layers as in a head: air, skin, bone, brain.
inline double headLayers(double r) {
  return r > 17 ? -1000 : r > 15 ? 60 : r > 12.5 ? 1200 : 30;
}

template <class T>
constexpr const char* kTypeName = std::is_same_v<T, uint8_t>    ? "uint8"
                                  : std::is_same_v<T, int16_t>  ? "int16"
                                  : std::is_same_v<T, uint16_t> ? "uint16"
                                                                : "float32";

class Kinds {
 public:
  template <class T>
  void add(const std::string& what, const std::string& name, const Voxel& voxel) {
    all.push_back({fmt::format("{}_{}x{}x{}_{}.raw", what, kSide, kSide, kSide, kTypeName<T>), name,
                   rawBytes<T>(voxel)});
  }
  std::vector<Kind> all;
};

inline std::vector<Kind> kinds() {
  Kinds result;
  result.add<uint8_t>("em", "solid", [](auto x, auto y, auto z) {
    return std::clamp(140 + 38 * normalNoise(x, y, z), 0.0, 255.0);
  });
  result.add<uint8_t>("filled_em", "solid", [](auto x, auto y, auto z) {
    return y < 6 ? 0 : std::clamp(140 + 30 * normalNoise(x, y, z), 1.0, 255.0);
  });
  result.add<int16_t>("ct", "above", [](auto x, auto y, auto z) {
    const double half = (kSide - 1) / 2.0;
    if (std::hypot(static_cast<double>(x) - half, static_cast<double>(y) - half) > 19.5)
      return -2000.0;
    return headLayers(fromCenter(x, y, z)) + 15 * normalNoise(x, y, z);
  });
  result.add<uint8_t>("mask", "surface",
                      [](auto x, auto y, auto z) { return fromCenter(x, y, z) < 14 ? 1 : 0; });
  result.add<uint16_t>("labels", "labels", [](auto x, auto y, auto z) {
    if (fromCenter(x, y, z) > 17) return 0;
    return x < 20 ? (y < 20 ? 17 : 1001) : z < 20 ? 3 : 240;
  });
  result.add<uint16_t>("vessels", "tail", [](auto x, auto y, auto z) {
    const double wave = 6 * std::sin(static_cast<double>(z) / 6);
    const double axis = std::hypot(static_cast<double>(x) - 20 - wave, static_cast<double>(y) - 20);
    const double brain = fromCenter(x, y, z) < 19 ? 150 : 10;
    return std::max(0.0, (axis < 2.2 ? 600 - 60 * axis : brain) + 12 * normalNoise(x, y, z));
  });
  result.add<float>("smoke", "above", [](auto x, auto y, auto z) {
    return std::max(0.0, std::exp(-fromCenter(x, y, z) / 6) * (1 + 0.3 * noise(x, y, z)) - 0.05);
  });
  result.add<uint8_t>("bright", "below", [](auto x, auto y, auto z) {
    return std::clamp((fromCenter(x, y, z) < 12 ? 110 : 249) + 2 * normalNoise(x, y, z), 0.0,
                      255.0);
  });
  result.add<float>("signed", "beyond", [](auto x, auto y, auto z) {
    return normalNoise(x / 3, y / 3, z / 3) * std::exp(-fromCenter(x, y, z) / 5);
  });
  result.add<float>("ocean", "", [](auto x, auto y, auto z) {
    return x < 8 ? 1e20 : 10 + static_cast<double>(z) / 4 + noise(x, y, z);
  });
  return result.all;
}

}  // namespace sluice
