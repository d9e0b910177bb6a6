#include "tools/scene/strip_drawing.h"

#include <algorithm>
#include <utility>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/library/empty_picture.h"
#include "src/library/picture_memory.h"

namespace sluice {
namespace {

void add(StageSeconds& sum, const StageSeconds& more) {
  sum.classify += more.classify;
  sum.plan += more.plan;
  sum.read += more.read;
  sum.decode += more.decode;
  sum.copy += more.copy;
  sum.upload += more.upload;
  sum.draw += more.draw;
  sum.boxes += more.boxes;
}

void add(OcclusionReport& sum, const OcclusionReport& more) {
  sum.updates_wanted += more.updates_wanted;
  sum.updates += more.updates;
  sum.cells += more.cells;
  sum.cells_culled += more.cells_culled;
  sum.cells_clipped += more.cells_clipped;
  sum.chunks_hidden += more.chunks_hidden;
  sum.seconds += more.seconds;
}

// Adds the work and the time of a strip; blocks and plans count the whole picture already.
void add(FrameReport& sum, const FrameReport& more) {
  sum.seconds += more.seconds;
  add(sum.stages, more.stages);
  sum.samples_drawn += more.samples_drawn;
  sum.samples_taken += more.samples_taken;
  sum.samples_object += more.samples_object;
  sum.boxes_drawn += more.boxes_drawn;
  sum.pages_loaded += more.pages_loaded;
  sum.binds += more.binds;
  sum.decoded_bytes += more.decoded_bytes;
  sum.copied_bytes += more.copied_bytes;
  sum.uploaded_bytes += more.uploaded_bytes;
  sum.missing_share = std::max(sum.missing_share, more.missing_share);
  add(sum.occlusion, more.occlusion);
  sum.cut = more.cut;  // the last strip knows the spreads of all blocks
}

// Rows makes the device draw rows; after its end the device draws whole pictures again.
class Rows {
 public:
  explicit Rows(Device& device) : device_(dynamic_cast<DrawsRows*>(&device)) {
    SLUICE_CHECK(device_ != nullptr);
  }
  ~Rows() { device_->drawRows(std::nullopt); }
  Rows(const Rows&) = delete;
  Rows& operator=(const Rows&) = delete;

  void draw(PictureRows rows) { device_->drawRows(rows); }

 private:
  DrawsRows* const device_;
};

}  // namespace

std::vector<PictureRows> stripsFor(const Scene& scene) {
  if (scene.share) return {{0, scene.pictures.size.height}};
  return stripsOf(scene.pictures, scene.part_bytes);
}

namespace {

// Writes the rows of one strip, or of the whole picture.
void write(const Picture& rows, PictureWriter* writer, WrittenFrame& drawn) {
  drawn.shows_something = drawn.shows_something || !showsNothing(rows);
  if (writer == nullptr) return;
  const Stopwatch watch;
  writer->add(rows);
  drawn.write_seconds += watch.seconds();
}

WrittenFrame drawWhole(Scene& scene, PictureWriter* writer) {
  WrittenFrame drawn;
  drawn.whole = scene.frame();
  scene.noteMemory();
  drawn.report = drawn.whole->report;
  drawn.blocks = drawn.whole->blocks;
  write(drawn.whole->picture, writer, drawn);
  return drawn;
}

}  // namespace

WrittenFrame drawFrameOf(Scene& scene, const std::vector<PictureRows>& strips,
                         PictureWriter* writer) {
  if (strips.size() == 1) return drawWhole(scene, writer);
  WrittenFrame drawn;
  Rows rows(*scene.device);
  for (const PictureRows& strip : strips) {
    rows.draw(strip);
    Frame frame = scene.frame();
    scene.noteMemory();
    if (drawn.blocks == nullptr) {
      drawn.blocks = frame.blocks;
      drawn.report = frame.report;
    } else {
      add(drawn.report, frame.report);
    }
    write(frame.picture, writer, drawn);
    scene.device->reuse(std::move(frame.picture));
  }
  return drawn;
}

}  // namespace sluice
