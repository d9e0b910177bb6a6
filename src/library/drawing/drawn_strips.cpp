#include "src/library/drawing/drawn_strips.h"

#include <utility>

#include "src/library/drawing/empty_picture.h"

namespace sluice {

DrawnStrips drawStrips(Device& device, const std::vector<PictureRows>& strips,
                       const std::function<Frame()>& draw,
                       const std::function<void(const Picture&)>& take) {
  DrawnStrips drawn;
  StripsOfDevice rows(device);
  for (const PictureRows& strip : strips) {
    rows.draw(strip);
    Frame frame = draw();
    if (drawn.blocks == nullptr) {
      drawn.blocks = frame.blocks;
      drawn.report = frame.report;
    } else {
      addStrip(drawn.report, frame.report);
    }
    drawn.shows_something = drawn.shows_something || !showsNothing(frame.picture);
    take(frame.picture);
    device.reuse(std::move(frame.picture));
  }
  return drawn;
}

}  // namespace sluice
