// EGL without a window: a device, the surfaceless platform or the default display.
//
// Displays are initialised and never terminated: EGL has one display per device in a process, and
// eglTerminate would take it from under the other contexts of the process.
#define EGL_NO_X11  // the platform types of X11 are not needed, nor its headers
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>

#include "src/base/error.h"
#include "src/base/files/shared_library.h"
#include "src/gl/contexts/backends.h"

namespace sluice {
namespace {

constexpr const char* kInstallEgl = "Debian: apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri";

// Compares whole words of a list separated by blanks, as EGL gives its extensions; null is an empty
// list.
bool contains(const char* list, std::string_view word) {
  std::string_view rest = list == nullptr ? "" : list;
  while (!rest.empty()) {
    const size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == word) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

struct EglApi {
  explicit EglApi(const SharedLibrary& library)
      : find(library.get<PFNEGLGETPROCADDRESSPROC>("eglGetProcAddress")),
        get_error(library.get<PFNEGLGETERRORPROC>("eglGetError")),
        get_display(library.get<PFNEGLGETDISPLAYPROC>("eglGetDisplay")),
        initialize(library.get<PFNEGLINITIALIZEPROC>("eglInitialize")),
        query_string(library.get<PFNEGLQUERYSTRINGPROC>("eglQueryString")),
        bind_api(library.get<PFNEGLBINDAPIPROC>("eglBindAPI")),
        choose_config(library.get<PFNEGLCHOOSECONFIGPROC>("eglChooseConfig")),
        create_pbuffer(library.get<PFNEGLCREATEPBUFFERSURFACEPROC>("eglCreatePbufferSurface")),
        destroy_surface(library.get<PFNEGLDESTROYSURFACEPROC>("eglDestroySurface")),
        create_context(library.get<PFNEGLCREATECONTEXTPROC>("eglCreateContext")),
        destroy_context(library.get<PFNEGLDESTROYCONTEXTPROC>("eglDestroyContext")),
        make_current(library.get<PFNEGLMAKECURRENTPROC>("eglMakeCurrent")) {
    // Extensions of the client, which are there before any display (EGL_EXT_client_extensions).
    const char* const client = query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (contains(client, "EGL_EXT_platform_base"))
      load(get_platform_display, "eglGetPlatformDisplayEXT");
    has_surfaceless = contains(client, "EGL_MESA_platform_surfaceless");
    has_device_platform = contains(client, "EGL_EXT_platform_device");
    if (contains(client, "EGL_EXT_device_base") || contains(client, "EGL_EXT_device_enumeration"))
      load(query_devices, "eglQueryDevicesEXT");
    if (contains(client, "EGL_EXT_device_base") || contains(client, "EGL_EXT_device_query"))
      load(query_device_string, "eglQueryDeviceStringEXT");
  }

  template <class Function>
  void load(Function& function, const char* name) {
    function = reinterpret_cast<Function>(find(name));
  }

  PFNEGLGETPROCADDRESSPROC find;
  PFNEGLGETERRORPROC get_error;
  PFNEGLGETDISPLAYPROC get_display;
  PFNEGLINITIALIZEPROC initialize;
  PFNEGLQUERYSTRINGPROC query_string;
  PFNEGLBINDAPIPROC bind_api;
  PFNEGLCHOOSECONFIGPROC choose_config;
  PFNEGLCREATEPBUFFERSURFACEPROC create_pbuffer;
  PFNEGLDESTROYSURFACEPROC destroy_surface;
  PFNEGLCREATECONTEXTPROC create_context;
  PFNEGLDESTROYCONTEXTPROC destroy_context;
  PFNEGLMAKECURRENTPROC make_current;
  // Null if the library has no such extension.
  PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display = nullptr;
  PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;
  PFNEGLQUERYDEVICESTRINGEXTPROC query_device_string = nullptr;
  bool has_surfaceless = false, has_device_platform = false;
};

EglApi openEgl(const GlLibraries& libraries) {
  prepareGlEnvironment();
  return EglApi(SharedLibrary(libraries.egl, kInstallEgl));
}

std::vector<EGLDeviceEXT> devicesOf(const EglApi& egl) {
  EGLint count = 0;
  if (egl.query_devices == nullptr || !egl.query_devices(0, nullptr, &count)) return {};
  std::vector<EGLDeviceEXT> devices(static_cast<size_t>(std::max(count, 0)));
  if (!egl.query_devices(count, devices.data(), &count)) return {};
  devices.resize(static_cast<size_t>(count));
  return devices;
}

EglDevice describeDevice(const EglApi& egl, EGLDeviceEXT device, size_t index) {
  EglDevice result{.name = fmt::format("device {}", index)};
  if (egl.query_device_string == nullptr) return result;
  const char* const extensions = egl.query_device_string(device, EGL_EXTENSIONS);
  result.is_software = contains(extensions, "EGL_MESA_device_software");
  if (result.is_software) result.name += " (software)";
  if (!contains(extensions, "EGL_EXT_device_drm")) return result;
  const char* const path = egl.query_device_string(device, EGL_DRM_DEVICE_FILE_EXT);
  if (path != nullptr && *path != '\0') result.name = path;
  return result;
}

EGLDisplay deviceDisplay(const EglApi& egl, int index) {
  const std::vector<EGLDeviceEXT> devices = devicesOf(egl);
  if (index < 0 || static_cast<size_t>(index) >= devices.size() || !egl.has_device_platform ||
      egl.get_platform_display == nullptr)
    failSystem("EGL has no device {} (it lists {})", index, devices.size());
  return egl.get_platform_display(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<size_t>(index)],
                                  nullptr);
}

EGLDisplay openDisplay(const EglApi& egl, EglTarget target) {
  EGLDisplay display = EGL_NO_DISPLAY;
  if (target.platform == EglPlatform::kDevice) {
    display = deviceDisplay(egl, target.device);
  } else if (target.platform == EglPlatform::kSurfaceless) {
    if (!egl.has_surfaceless || egl.get_platform_display == nullptr)
      failSystem("EGL has no surfaceless platform");
    display = egl.get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  } else {
    display = egl.get_display(EGL_DEFAULT_DISPLAY);
  }
  if (display == EGL_NO_DISPLAY) failSystem("EGL opens no display ({:#06x})", egl.get_error());
  if (!egl.initialize(display, nullptr, nullptr))
    failSystem(
        "EGL does not initialise its display ({:#06x}): no display server, no driver, or no right "
        "to open the device",
        egl.get_error());
  return display;
}

class EglContext : public GlContext {
 public:
  EglContext(const EglApi& egl, EGLDisplay display, std::string device)
      : GlContext("egl", std::move(device)), egl_(egl), display_(display) {
    if (!egl_.bind_api(EGL_OPENGL_API)) failSystem("EGL offers OpenGL ES only, not OpenGL");
    const char* const extensions = egl_.query_string(display_, EGL_EXTENSIONS);
    const bool needs_surface = !contains(extensions, "EGL_KHR_surfaceless_context");
    const EGLConfig config = !needs_surface && contains(extensions, "EGL_KHR_no_config_context")
                                 ? EGL_NO_CONFIG_KHR
                                 : chooseConfig(needs_surface);
    if (needs_surface) createSurface(config);
    for (const int version : kCoreVersions) {
      const std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION,
                                             version / 10,
                                             EGL_CONTEXT_MINOR_VERSION,
                                             version % 10,
                                             EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                             EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                             EGL_NONE};
      handle_ = egl_.create_context(display_, config, EGL_NO_CONTEXT, attributes.data());
      if (handle_ != EGL_NO_CONTEXT) return;
    }
    // Taken before another call replaces it.
    const EGLint error = egl_.get_error();
    destroySurface();
    failSystem("EGL offers no core profile of 3.3 or higher ({:#06x})", error);
  }
  ~EglContext() override {
    release();
    egl_.destroy_context(display_, handle_);
    destroySurface();
  }

  void start() {
    makeCurrent();
    describe([this](const char* name) { return reinterpret_cast<void*>(egl_.find(name)); });
  }

 protected:
  void bind() override {
    // The API is a state of the thread, which may be another one than the creator's.
    if (!egl_.bind_api(EGL_OPENGL_API) || !egl_.make_current(display_, surface_, surface_, handle_))
      failSystem("EGL does not make its context current ({:#06x})", egl_.get_error());
  }
  void unbind() noexcept override {
    egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

 private:
  EGLConfig chooseConfig(bool needs_surface) const {
    const std::array<EGLint, 5> attributes{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE,
                                           needs_surface ? EGL_PBUFFER_BIT : EGL_DONT_CARE,
                                           EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (!egl_.choose_config(display_, attributes.data(), &config, 1, &count) || count < 1)
      failSystem("EGL offers no configuration for OpenGL ({:#06x})", egl_.get_error());
    return config;
  }
  // A surface of one pixel, for drivers that make no context current without a surface.
  void createSurface(EGLConfig config) {
    const std::array<EGLint, 5> attributes{EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    surface_ = egl_.create_pbuffer(display_, config, attributes.data());
    if (surface_ == EGL_NO_SURFACE)
      failSystem("EGL creates no surface ({:#06x})", egl_.get_error());
  }
  void destroySurface() noexcept {
    if (surface_ != EGL_NO_SURFACE) egl_.destroy_surface(display_, surface_);
  }

  const EglApi egl_;
  const EGLDisplay display_;
  EGLSurface surface_ = EGL_NO_SURFACE;
  EGLContext handle_ = EGL_NO_CONTEXT;
};

std::string targetName(const EglApi& egl, EglTarget target) {
  if (target.platform == EglPlatform::kSurfaceless) return "surfaceless";
  if (target.platform == EglPlatform::kDefault) return "default display";
  const auto index = static_cast<size_t>(target.device);
  return describeDevice(egl, devicesOf(egl)[index], index).name;
}

}  // namespace

std::vector<EglDevice> listEglDevices(const GlLibraries& libraries) {
  const EglApi egl = openEgl(libraries);
  std::vector<EglDevice> result;
  for (EGLDeviceEXT device : devicesOf(egl))
    result.push_back(describeDevice(egl, device, result.size()));
  return result;
}

std::unique_ptr<GlContext> createEglContext(const GlLibraries& libraries, EglTarget target) {
  const EglApi egl = openEgl(libraries);
  const EGLDisplay display = openDisplay(egl, target);
  auto context = std::make_unique<EglContext>(egl, display, targetName(egl, target));
  context->start();
  return context;
}

}  // namespace sluice
