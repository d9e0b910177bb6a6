// Draws a volume that a function of the program gives box by box. Here it is computed; a reader of
// a format of your own, or of a database, is plugged in like this:
//   custom_source OUT.png
#include <sluice/sluice.h>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>

namespace {

constexpr int64_t kSide = 400;

// The gyroid, a surface without an end that parts space into two mazes, at the centre of a voxel.
double gyroid(int64_t x, int64_t y, int64_t z) {
  const auto angle = [](int64_t at) { return 0.06 * static_cast<double>(at); };
  return std::sin(angle(x)) * std::cos(angle(y)) + std::sin(angle(y)) * std::cos(angle(z)) +
         std::sin(angle(z)) * std::cos(angle(x));
}

// Several threads of the library call this at once, and may ask for a box again.
void fill(int64_t /*time*/, const std::array<int64_t, 3>& lo, const std::array<int64_t, 3>& hi,
          std::span<std::byte> out) {
  size_t at = 0;
  for (int64_t z = lo[2]; z < hi[2]; ++z)
    for (int64_t y = lo[1]; y < hi[1]; ++y)
      for (int64_t x = lo[0]; x < hi[0]; ++x)
        out[at++] = static_cast<std::byte>(std::lround(127.5 + 80 * gyroid(x, y, z)));
}

const char* adviceFor(sluice::Error::Kind kind) {
  switch (kind) {
    case sluice::Error::Kind::kMemory:
      return "give it more memory";
    case sluice::Error::Kind::kSystem:
      return "look at this machine";
    default:
      return "look at the call";
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fputs("usage: custom_source OUT.png\n", stderr), 2;
  const sluice::Volume volume = sluice::Volume::fromFunction(
      fill, {.dims = {kSide, kSide, kSide}, .type = "u8", .name = "gyroid"},
      {.memory_bytes = 64 << 20}, [](const sluice::Progress& so_far) {
        std::fprintf(stderr, "\rlooking at the voxels: %3.0f %%", 100 * so_far.share());
      });
  std::fputc('\n', stderr);

  sluice::Renderer renderer(volume, {.surfaces = {{.value = 127.5, .color = "ff8800"}}},
                            {.memory_bytes = 256 << 20});
  renderer.drawToFile(argv[1], {.width = 800, .height = 600, .view = {.zoom = 1.2}});
  return 0;
} catch (const sluice::Error& error) {
  std::fprintf(stderr, "custom_source: %s (%s)\n", error.what(), adviceFor(error.kind()));
  return 1;
}
