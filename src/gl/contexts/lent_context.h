// A GlContext that somebody else made and owns, such as a window's toolkit.
#pragma once

#include <functional>
#include <memory>

#include "src/gl/contexts/context.h"

namespace sluice {

// OpenGL 3.3 core or later. It is current on no other thread while it is used, and outlives that.
struct LentContext {
  std::function<void()> make_current;  // on the calling thread; throws Error
  std::function<void()> release;       // leaves the calling thread without one; throws nothing
  std::function<void*(const char*)> find;
};

// "window" by its backend. Current on the calling thread, as of createContext(). Throws Error.
std::unique_ptr<GlContext> createLentContext(LentContext lent);

}  // namespace sluice
