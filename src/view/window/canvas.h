// Canvas: the window's pixels, kept from one frame to the next, so that a frame draws only the
// regions that changed (changed_area.h), and nothing if none did. It keeps them upside down: a
// window's rows then are its own, and software copies them as they are. The window's thread, its
// context current.
#pragma once

#include <imgui.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "src/view/state/screen/changed_area.h"

namespace sluice {

class Canvas {
 public:
  // Throws Error if the driver lacks functions of OpenGL 3.3.
  Canvas();
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  // Pixels behind all that ImGui draws, in place of a texture that a processor would have to
  // filter: at these pixels of the window, from its upper left corner. Kept until the next.
  struct Backdrop {
    int left = 0, top = 0, width = 0, height = 0;
    std::vector<uint32_t> bgra;  // rows from the top
  };
  // The current backdrop, to be written over; its old and new areas are then drawn again.
  Backdrop& renewBackdrop();
  void dropBackdrop();

  // The content of this texture (an ImTextureID) has changed since the last frame.
  void noteRedrawn(const void* texture);
  // Returns the regions that changed since the last frame; all of the frame if nothing was drawn
  // yet. Requires: the data come from ImGui's last Render().
  const std::vector<ScreenArea>& compare(const ImDrawData& data, int width, int height);
  // Draws those areas, and puts all of the canvas on the window's back buffer. Leaves the data's
  // commands cut to the areas.
  void draw(ImDrawData& data);
  // Pixels of the areas that were drawn last.
  uint64_t drawnPixels() const { return drawn_pixels_; }

 private:
  struct Functions;
  void resize(int width, int height);
  void drawBackdrop(const ScreenArea& area);

  std::unique_ptr<const Functions> gl_;
  unsigned framebuffer_ = 0, pixels_ = 0;
  int width_ = 0, height_ = 0;
  bool is_new_ = true, backdrop_is_new_ = false;
  Backdrop backdrop_;
  ScreenArea backdrop_was_;
  std::vector<DrawnList> last_, now_;
  std::vector<uint64_t> redrawn_;
  std::vector<ScreenArea> areas_;
  float scale_x_ = 1, scale_y_ = 1;  // pixels a unit
  uint64_t drawn_pixels_ = 0;
};

}  // namespace sluice
