#include "src/gl/contexts/context.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>

#include "src/base/error.h"
#include "src/base/threads/kept_addresses.h"
#include "src/base/threads/threads.h"
#include "src/base/values/bytes.h"
#include "src/gl/contexts/backends.h"

namespace sluice {
namespace {

// The thread's current context of ours: a mirror of the state that GL keeps for a thread. Mesa's
// OSMesa and EGL share one dispatch table (libglapi), and neither knows of the other: each lets go
// through its own library before the other takes the thread, so that neither touches a context of
// the other's.
GlContext*& currentOfThread() {
  thread_local GlContext* current = nullptr;
  return current;
}

bool isSoftwareRenderer(std::string_view renderer) {
  constexpr std::array kNames{"llvmpipe", "softpipe", "swrast", "SWR", "Software Rasterizer"};
  return std::ranges::any_of(
      kNames, [&](const char* name) { return renderer.find(name) != std::string_view::npos; });
}

std::string text(const GlFunctions& gl, GLenum what) {
  const GLubyte* const value = gl.GetString(what);
  return value == nullptr ? std::string() : reinterpret_cast<const char*>(value);
}

int integer(const GlFunctions& gl, GLenum what) {
  GLint value = 0;
  gl.GetIntegerv(what, &value);
  return value;
}

GlLimits limitsOf(const GlFunctions& gl) {
  std::array<GLint, 2> viewport{};
  gl.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport.data());
  return {.max_3d_texture_size = integer(gl, GL_MAX_3D_TEXTURE_SIZE),
          .max_texture_size = integer(gl, GL_MAX_TEXTURE_SIZE),
          .max_viewport_size = std::min(viewport[0], viewport[1]),
          .max_texture_units = integer(gl, GL_MAX_TEXTURE_IMAGE_UNITS)};
}

// Tries one way after another and remembers why each failed.
class Attempts {
 public:
  // Returns null if `create` throws Error.
  std::unique_ptr<GlContext> attempt(const std::string& what,
                                     const std::function<std::unique_ptr<GlContext>()>& create) {
    try {
      return create();
    } catch (const Error& error) {
      note(what, error.what());
      return nullptr;
    }
  }
  void note(const std::string& what, const std::string& reason) {
    if (!reasons_.empty()) reasons_ += "; ";
    reasons_ += what + ": " + reason;
  }
  const std::string& reasons() const { return reasons_; }

 private:
  std::string reasons_;
};

// The devices that are, or are not, software; a libEGL that does not open is noted once.
std::unique_ptr<GlContext> tryDevices(Attempts& attempts, const GlLibraries& libraries,
                                      const std::vector<EglDevice>& devices, bool software) {
  for (size_t i = 0; i < devices.size(); ++i) {
    if (devices[i].is_software != software) continue;
    auto context = attempts.attempt("egl " + devices[i].name, [&] {
      return createEglContext(libraries, {EglPlatform::kDevice, static_cast<int>(i)});
    });
    if (context != nullptr && (software || !context->isSoftware())) return context;
    if (context != nullptr) attempts.note("egl " + devices[i].name, "draws in software");
  }
  return nullptr;
}

std::unique_ptr<GlContext> trySoftwareEgl(Attempts& attempts, const GlLibraries& libraries,
                                          const std::vector<EglDevice>& devices) {
  auto context = tryDevices(attempts, libraries, devices, true);
  if (context == nullptr)
    context = attempts.attempt("egl surfaceless", [&] {
      return createEglContext(libraries, {EglPlatform::kSurfaceless});
    });
  if (context == nullptr)
    context = attempts.attempt("egl default display", [&] {
      return createEglContext(libraries, {EglPlatform::kDefault});
    });
  return context;
}

}  // namespace

void prepareGlEnvironment() {
  // Mesa does not look whether it got the memory that it asked for. Its libraries take 160 MiB.
  constexpr size_t kLeastAddresses = size_t{352} << 20;
  if (!KeptAddresses(kLeastAddresses).areThere())
    failSystem("OpenGL needs {} more of addresses than `ulimit -v` leaves; raise it",
               formatBytes(kLeastAddresses));
  setenv("GALLIVM_PERF", kExactSampling, 0);
  setenv("EGL_LOG_LEVEL", "fatal", 0);
  // llvmpipe's own most is 16. It waits forever for threads that it does not get: if they are
  // limited, it draws with none.
  const int wanted = std::min(16, 4 * processorCount());
  const int threads = startableThreads(wanted) == wanted ? wanted : 0;
  setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), 0);
}

void GlContext::makeCurrent() {
  GlContext*& current = currentOfThread();
  if (current == this) return;
  if (current != nullptr) current->release();
  // Current only once bind() has not thrown.
  bind();
  current = this;
}

void GlContext::release() noexcept {
  GlContext*& current = currentOfThread();
  if (current != this) return;
  unbind();
  current = nullptr;
}

void GlContext::describe(const GlLoader& loader) {
  functions_ = loadGlFunctions(loader);
  renderer_ = text(functions_, GL_RENDERER);
  version_ = text(functions_, GL_VERSION);
  is_software_ = isSoftwareRenderer(renderer_);
  limits_ = limitsOf(functions_);
  const int count = integer(functions_, GL_NUM_EXTENSIONS);
  for (int i = 0; i < count; ++i)
    extensions_.emplace_back(reinterpret_cast<const char*>(
        functions_.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))));
  // has() asks for it.
  std::ranges::sort(extensions_);
}

bool GlContext::has(std::string_view extension) const {
  return std::ranges::binary_search(extensions_, extension);
}

std::unique_ptr<GlContext> createContext(GlChoice choice, const GlLibraries& libraries) {
  Attempts attempts;
  std::unique_ptr<GlContext> context;
  std::vector<EglDevice> devices;
  bool has_egl = false;
  if (choice != GlChoice::kOsmesa) {
    try {
      devices = listEglDevices(libraries);
      has_egl = true;
      context = tryDevices(attempts, libraries, devices, false);
    } catch (const Error& error) {
      attempts.note("egl", error.what());
    }
  }
  if (context == nullptr && choice != GlChoice::kEgl)
    context = attempts.attempt("osmesa", [&] { return createOsmesaContext(libraries); });
  if (context == nullptr && has_egl) context = trySoftwareEgl(attempts, libraries, devices);
  if (context == nullptr)
    failSystem("no OpenGL 3.3 context with --gl {}: {}", name(choice), attempts.reasons());
  return context;
}

std::unique_ptr<GlContext> createHardwareContext(const GlLibraries& libraries) {
  Attempts attempts;
  try {
    return tryDevices(attempts, libraries, listEglDevices(libraries), false);
  } catch (const Error&) {  // no libEGL
    return nullptr;
  }
}

}  // namespace sluice
