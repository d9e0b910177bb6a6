// Draws an array that the program has in memory already, without a copy of it:
//   array OUT.png
#include <sluice/sluice.h>

#include <cmath>
#include <cstdio>
#include <vector>

namespace {

constexpr int kSide = 128;

// Two drops that flow together, as floats; x is the slowest axis here, as in many simulations.
std::vector<float> field() {
  const auto drop = [](double x, double y, double z, double middle) {
    const double dx = x - middle, dy = y - 0.5, dz = z - 0.5;
    return 0.02 / (dx * dx + dy * dy + dz * dz + 1e-3);
  };
  std::vector<float> values;
  values.reserve(size_t{kSide} * kSide * kSide);
  for (int x = 0; x < kSide; ++x)
    for (int y = 0; y < kSide; ++y)
      for (int z = 0; z < kSide; ++z) {
        const double scale = 1.0 / (kSide - 1);
        values.push_back(static_cast<float>(drop(x * scale, y * scale, z * scale, 0.35) +
                                            drop(x * scale, y * scale, z * scale, 0.65)));
      }
  return values;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fputs("usage: array OUT.png\n", stderr), 2;
  const std::vector<float> values = field();
  const sluice::ArrayLayout layout = {
      .dims = {kSide, kSide, kSide}, .type = "f32", .spacing = {0.5, 0.5, 0.5}, .unit = "mm"};
  constexpr int64_t kPlane = int64_t{kSide} * kSide * sizeof(float);
  const sluice::ArrayStrides strides{kPlane, kSide * sizeof(float), sizeof(float), 0};

  // The array must stay as it is while the volume is open.
  const sluice::Volume volume = sluice::Volume::borrow(values.data(), layout, strides);
  const auto [least, greatest] = volume.info().value_range;
  std::printf("values from %.3f to %.3f\n", least, greatest);

  sluice::Renderer renderer(volume, {.opacities = {{0.4, 0}, {0.6, 0.1}, {greatest, 0.4}}});
  renderer.draw({.view = {.azimuth_deg = 30}}).writePng(argv[1]);
  std::printf("%llu of %llu bytes were copied\n",
              static_cast<unsigned long long>(renderer.report().volume_buffer.peak_bytes),
              static_cast<unsigned long long>(values.size() * sizeof(float)));
  return 0;
} catch (const sluice::Error& error) {
  std::fprintf(stderr, "array: %s\n", error.what());
  return 1;
}
