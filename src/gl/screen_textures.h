// ScreenTextures: copies of float pictures as a screen shows them, each behind a fence, in a few
// textures that take turns. Its context must be current in every call.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "src/device/frame_values.h"
#include "src/device/pictures/screen_picture.h"
#include "src/gl/contexts/gl_functions.h"
#include "src/gl/shaders/gl_program.h"

namespace sluice {

class ScreenTextures {
 public:
  explicit ScreenTextures(const GlFunctions& gl) : gl_(gl) {}
  // Leaves to its reader each texture that is still held.
  ~ScreenTextures();
  ScreenTextures(const ScreenTextures&) = delete;
  ScreenTextures& operator=(const ScreenTextures&) = delete;

  // `picture`, premultiplied, its rows upwards, over an opaque background. Waits until the driver
  // knows whether it shows anything. Changes the framebuffer, the program, the viewport and the
  // first texture unit. Throws Error if the driver refuses.
  ScreenPicture make(GLuint picture, PictureSize size, std::array<float, 3> background);

 private:
  struct Slot {
    GLuint texture = 0;
    PictureSize size{0, 0};
    GLsync drawn = nullptr;
    std::shared_ptr<std::atomic<void*>> seen;
    std::shared_ptr<std::atomic<bool>> is_let_go;
  };
  // A slot of this size that nobody reads any more.
  Slot& freeSlot(PictureSize size);
  void makePrograms();
  // Whether any pixel of the bound picture shows something. Draws into the bound framebuffer.
  bool showsSomething();

  const GlFunctions& gl_;
  std::vector<Slot> slots_;
  std::unique_ptr<GlProgram> over_, shown_;
  GLuint framebuffer_ = 0, query_ = 0;
};

}  // namespace sluice
