// Canvas: the window's pixels, kept from one frame to the next, so that a frame draws only what is
// another than in the last one (changed_area.h) and a frame in which nothing is draws nothing. The
// window's thread, its context current.
#pragma once

#include <imgui.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "src/view/changed_area.h"

namespace sluice {

class Canvas {
 public:
  // Throws Error where the driver lacks what OpenGL 3.3 has.
  Canvas();
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  // The content of this texture (an ImTextureID) is another than in the last frame.
  void noteRedrawn(const void* texture);
  // What of the frame is another than what was drawn last; `all` of it where nothing was.
  // Requires: the data are those of ImGui's last Render().
  const std::vector<ScreenArea>& compare(const ImDrawData& data, int width, int height);
  // Draws those areas, and puts all of the canvas on the window's back buffer. Leaves the data's
  // commands cut to the areas.
  void draw(ImDrawData& data);
  // Of the areas that were drawn last.
  uint64_t drawnPixels() const { return drawn_pixels_; }

 private:
  struct Functions;
  void resize(int width, int height);

  std::unique_ptr<const Functions> gl_;
  unsigned framebuffer_ = 0, pixels_ = 0;
  int width_ = 0, height_ = 0;
  bool is_new_ = true;
  std::vector<DrawnList> last_, now_;
  std::vector<uint64_t> redrawn_;
  std::vector<ScreenArea> areas_;
  uint64_t drawn_pixels_ = 0;
};

}  // namespace sluice
