// Pictures for a window that draws with OpenGL: they stay in textures that it can show.
#pragma once

#include <atomic>
#include <functional>
#include <memory>

namespace sluice {

// An OpenGL context, 3.3 core or later, that shares its textures with the window's and is current
// nowhere else. A Renderer that was given it draws in it, on a thread of the Renderer's own; it
// must outlive the Renderer.
struct ScreenContext {
  std::function<void()> make_current;  // on the calling thread; throws Error
  std::function<void()> release;       // leaves the calling thread without one
  std::function<void*(const char*)> find;
};

// A texture in place of an Image's pixels: 8 bits a channel, opaque, rows from the top. Let the
// window's commands wait for `drawn` (glWaitSync) before they read it. When the texture is no
// longer shown, put a fence behind those commands into `seen` and release it; the Renderer then
// draws to the texture again. The last holder, the Renderer or the window, deletes these objects.
struct ScreenImage {
  unsigned texture = 0;
  int width = 0, height = 0;
  void* drawn = nullptr;  // GLsync
  std::shared_ptr<std::atomic<void*>> seen;
  double missing_share = 0;   // see Image
  bool will_improve = false;  // see Image
};

}  // namespace sluice
