// GlContext: an OpenGL core profile of at least 3.3 without a window, chosen at run time.
//
// A single binary supports OSMesa (Mesa's software renderer as a library) and EGL (a device, the
// surfaceless platform, or the default display). The libraries are opened with dlopen(RTLD_NOW |
// RTLD_LOCAL) when asked for and nothing links to them, so that the program starts if one is
// missing and their symbols never meet. They are never closed: Mesa leaves thread-local destructors
// and atexit handlers behind that would run in unmapped code.
//
// There is no picture to draw on: make a framebuffer object. The draw framebuffer 0 is incomplete
// or a few pixels wide.
//
// Threads: a context is current on one thread at a time, and its functions may be called on that
// thread only. createContext leaves the new context current on the calling thread. Several
// contexts, of several backends too, may exist at once and take turns on one thread through
// makeCurrent. A context must be current on no other thread when it is destroyed. createContext
// sets environment variables (below): call it before other threads read the environment.
//
// Environment. Mesa has no other interface for this, and variables that are already set stay.
// GALLIVM_PERF becomes kExactSampling: llvmpipe otherwise filters 8-bit textures in 8-bit
// arithmetic, which rounds every sample to 1/255 and shows against the reference picture.
// EGL_LOG_LEVEL becomes "fatal" if it is unset, so that trying one display after another prints
// nothing. LP_NUM_THREADS becomes four times the processors if it is unset: llvmpipe draws a
// picture in squares of 64 x 64 pixels, which differ in work. With a thread a processor, the last
// heavy squares keep one of them busy while the others wait. All are read when a library is first
// opened.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "src/gl/contexts/gl_choice.h"
#include "src/gl/contexts/gl_functions.h"

namespace sluice {

// The names the libraries are looked for under, in this order.
struct GlLibraries {
  std::vector<std::string> osmesa{"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};
  std::vector<std::string> egl{"libEGL.so.1", "libEGL.so"};
};

struct GlLimits {
  int max_3d_texture_size = 0;  // voxels along an axis
  int max_texture_size = 0;     // texels along an axis, 1D and 2D
  int max_viewport_size = 0;    // the smaller of width and height
  int max_texture_units = 0;    // for a fragment shader
};

class GlContext {
 public:
  virtual ~GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  // Makes this the calling thread's context in place of any other GlContext, of another backend
  // too; costs nothing when it is already. Throws Error when the library refuses.
  void makeCurrent();
  // Leaves the calling thread without a context, so that another thread may take this one. Does
  // nothing when this is not the calling thread's context.
  void release() noexcept;

  // Constant after construction, from any thread.
  const GlFunctions& functions() const { return functions_; }
  std::string_view backend() const { return backend_; }      // "osmesa" or "egl"
  const std::string& device() const { return device_; }      // GlProbe::device; "" for OSMesa
  const std::string& renderer() const { return renderer_; }  // GL_RENDERER
  const std::string& version() const { return version_; }    // GL_VERSION
  // Mesa's CPU rasterisers by their names: textures then live in the process's memory.
  bool isSoftware() const { return is_software_; }
  const GlLimits& limits() const { return limits_; }
  bool has(std::string_view extension) const;

 protected:
  // `backend` is a literal.
  GlContext(std::string_view backend, std::string device)
      : backend_(backend), device_(std::move(device)) {}
  // Fills everything above. Requires: the context is current. Throws Error when it is older than
  // 3.3 or lacks a function.
  void describe(const GlLoader& loader);
  // The library's own way of making this the thread's context and of leaving it with none. The
  // destructor of a derived class calls release() first.
  virtual void bind() = 0;
  virtual void unbind() noexcept = 0;

 private:
  // Constant after construction, set by describe() from renderer_ on.
  const std::string_view backend_;
  const std::string device_;
  std::string renderer_, version_;
  bool is_software_ = false;
  GlLimits limits_;
  std::vector<std::string> extensions_;  // sorted
  GlFunctions functions_;
};

// A new context, current on the calling thread, with the highest core version offered. Throws
// Error: the ways tried, why each failed and what to install.
std::unique_ptr<GlContext> createContext(GlChoice choice, const GlLibraries& libraries = {});
// The same on a GPU, through EGL; null if no GPU's driver works.
std::unique_ptr<GlContext> createHardwareContext(const GlLibraries& libraries = {});

}  // namespace sluice
