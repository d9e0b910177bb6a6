// Pictures that stay on the device, for a screen that shows textures of the same driver.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>

namespace sluice {

// A pixel of less opacity shows nothing: it changes no channel of 8 bits.
inline constexpr float kLeastOpacity = 0.5F / 255;

struct ScreenPicture {
  unsigned texture = 0;  // 8 bits a channel, opaque, rows from the top
  int width = 0, height = 0;
  void* drawn = nullptr;  // a fence (GLsync): whoever reads lets its commands wait for it
  // A fence behind the reader's last command, or null; whoever holds this keeps the texture from
  // being drawn to.
  std::shared_ptr<std::atomic<void*>> seen;
  // Set by the reader or the device as it lets go. The one that finds it set is the last, and
  // deletes texture and fences.
  std::shared_ptr<std::atomic<bool>> is_let_go;
  bool shows_something = true;  // any pixel has at least kLeastOpacity
};

// A device that can draw for screens implements this in addition to Device. Called on the device's
// thread.
class DrawsForScreens {
 public:
  virtual ~DrawsForScreens() = default;
  // The next frame that is no other mode's than composite, and has no depth, stays on the device,
  // over this background (red, green, blue, 0 to 1): endFrame() then gives a picture of its size
  // without pixels. nullopt: as ever.
  virtual void keepNext(std::optional<std::array<float, 3>> background) = 0;
  // The one that was kept since; nullopt: none was.
  virtual std::optional<ScreenPicture> takeKept() = 0;
};

}  // namespace sluice
