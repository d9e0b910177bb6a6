// How much memory does a turn around a volume need? Draws it within ever larger limits, prints what
// was read again, and records the requests for `sluice simulate`:
//   cache_study FILE THRESHOLD OUT.trace
#include <sluice/sluice.h>

#include <cstdio>
#include <cstdlib>

namespace {

// Draws 12 views around the volume. The renderer keeps what they share.
void turn(sluice::Renderer& renderer) {
  sluice::PictureOptions picture = {.width = 256, .height = 256};
  picture.view.fit = sluice::ViewOptions::Fit::kVolume;
  for (int i = 0; i < 12; ++i) {
    picture.view.azimuth_deg = 30.0 * i;
    renderer.draw(picture);
  }
}

void print(uint64_t limit, const sluice::RenderReport& report) {
  const sluice::LevelReport& buffer = report.volume_buffer;
  std::printf("%8.0f MiB %10.1f MiB read %8llu loads %8llu evictions %10llu pages uploaded\n",
              static_cast<double>(limit) / (1 << 20),
              static_cast<double>(report.read_bytes) / (1 << 20),
              static_cast<unsigned long long>(buffer.loads),
              static_cast<unsigned long long>(buffer.evictions),
              static_cast<unsigned long long>(report.pages_loaded));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) return std::fputs("usage: cache_study FILE THRESHOLD OUT.trace\n", stderr), 2;
  const sluice::Volume volume(argv[1]);
  const sluice::LookOptions look = {.threshold = std::strtod(argv[2], nullptr)};
  for (uint64_t limit = uint64_t{16} << 20; limit <= uint64_t{1} << 30; limit *= 4) try {
      sluice::Renderer renderer(volume, look, {.memory_bytes = limit});
      renderer.recordTo(argv[3]);  // the last and largest limit's trace stays
      turn(renderer);
      print(limit, renderer.report());
    } catch (const sluice::Error& error) {
      if (error.kind() != sluice::Error::Kind::kMemory) throw;
      std::printf("%8.0f MiB is too small\n", static_cast<double>(limit) / (1 << 20));
    }
  std::printf("sluice simulate %s\n", argv[3]);
  return 0;
} catch (const sluice::Error& error) {
  std::fprintf(stderr, "cache_study: %s\n", error.what());
  return 1;
}
