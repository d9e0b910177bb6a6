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
// longer shown, put a fence behind those commands into `seen`, delete the one that was there, set
// `is_let_go`, and release both; the Renderer then draws to the texture again. If is_let_go was
// true before (exchange() tells), the Renderer has ended: delete the texture, `drawn` and the fence
// in `seen`, too.
struct ScreenImage {
  unsigned texture = 0;
  int width = 0, height = 0;
  void* drawn = nullptr;                         // GLsync
  std::shared_ptr<std::atomic<void*>> seen;      // GLsync, or null
  std::shared_ptr<std::atomic<bool>> is_let_go;  // by the window, or by the Renderer that ends
  double missing_share = 0;                      // see Image
  bool will_improve = false;                     // see Image
};

}  // namespace sluice
