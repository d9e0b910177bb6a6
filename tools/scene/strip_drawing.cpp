#include "tools/scene/strip_drawing.h"

#include <utility>

#include "src/base/threads/clock.h"
#include "src/library/drawing/drawn_strips.h"
#include "src/library/drawing/empty_picture.h"
#include "src/library/drawing/picture_memory.h"

namespace sluice {

std::vector<PictureRows> stripsFor(const Scene& scene) {
  if (scene.share) return {{0, scene.pictures.size.height}};
  return stripsOf(scene.pictures, scene.part_bytes);
}

namespace {

// Writes the rows of one strip, or of the whole picture. Returns the seconds that it took.
double write(const Picture& rows, PictureWriter* writer) {
  if (writer == nullptr) return 0;
  const Stopwatch watch;
  writer->add(rows);
  return watch.seconds();
}

WrittenFrame drawWhole(Scene& scene, PictureWriter* writer) {
  WrittenFrame drawn;
  drawn.whole = scene.frame();
  scene.noteMemory();
  drawn.report = drawn.whole->report;
  drawn.blocks = drawn.whole->blocks;
  drawn.shows_something = !showsNothing(drawn.whole->picture);
  drawn.write_seconds = write(drawn.whole->picture, writer);
  return drawn;
}

}  // namespace

WrittenFrame drawFrameOf(Scene& scene, const std::vector<PictureRows>& strips,
                         PictureWriter* writer) {
  if (strips.size() == 1) return drawWhole(scene, writer);
  WrittenFrame written;
  const auto draw = [&] {
    Frame frame = scene.frame();
    scene.noteMemory();
    return frame;
  };
  DrawnStrips drawn = drawStrips(*scene.device, strips, draw, [&](const Picture& strip) {
    written.write_seconds += write(strip, writer);
  });
  written.report = std::move(drawn.report);
  written.blocks = std::move(drawn.blocks);
  written.shows_something = drawn.shows_something;
  return written;
}

}  // namespace sluice
