// Looks around a volume, calls one picture off, and saves the view from the front quarter:
//   turntable FILE THRESHOLD OUT.png
#include <sluice/sluice.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) try {
  if (argc != 4) return std::fputs("usage: turntable FILE THRESHOLD OUT.png\n", stderr), 2;
  const sluice::Volume volume(argv[1]);
  sluice::Renderer renderer(volume, {.threshold = std::strtod(argv[2], nullptr)});
  std::printf("%s on %s\n", volume.info().name.c_str(), renderer.deviceName().c_str());

  sluice::PictureOptions picture;
  for (picture.view.azimuth_deg = 90; picture.view.azimuth_deg < 360;) {
    renderer.draw(picture, [&](const sluice::Progress& so_far) {
      std::printf("%.0f degrees: %.0f %%\n", picture.view.azimuth_deg, 100 * so_far.share());
    });
    picture.view.azimuth_deg += 90;
  }
  try {
    std::stop_source stop;
    renderer.draw(
        picture, [&](const sluice::Progress&) { stop.request_stop(); }, stop.get_token());
  } catch (const sluice::Cancelled& cancelled) {
    std::printf("one picture: %s\n", cancelled.what());
  }
  renderer.draw().writePng(argv[3]);
  return 0;
} catch (const sluice::Error& error) {
  std::fprintf(stderr, "turntable: %s\n", error.what());
  return 1;
}
