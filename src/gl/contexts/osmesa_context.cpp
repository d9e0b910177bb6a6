// OSMesa: Mesa's software rasteriser drawing into memory of ours.
//
// osmesa.h brings GL/gl.h with it, whose prototypes serve here for their types only; it must come
// after the core profile's header, whose types it would hide.
#include "src/gl/contexts/backends.h"
// clang-format off
#include <GL/osmesa.h>
// clang-format on

#include <array>
#include <cstddef>

#include "src/base/error.h"
#include "src/base/files/shared_library.h"

namespace sluice {
namespace {

constexpr const char* kInstallOsmesa = "Debian: apt-get install libosmesa6";

struct OsmesaApi {
  explicit OsmesaApi(const SharedLibrary& library)
      : create(library.get<decltype(create)>("OSMesaCreateContextAttribs")),
        destroy(library.get<decltype(destroy)>("OSMesaDestroyContext")),
        make_current(library.get<decltype(make_current)>("OSMesaMakeCurrent")),
        find(library.get<decltype(find)>("OSMesaGetProcAddress")) {}

  decltype(&OSMesaCreateContextAttribs) create;
  decltype(&OSMesaDestroyContext) destroy;
  decltype(&OSMesaMakeCurrent) make_current;
  decltype(&OSMesaGetProcAddress) find;
};

class OsmesaContext : public GlContext {
 public:
  explicit OsmesaContext(const OsmesaApi& api) : GlContext("osmesa", ""), api_(api) {
    for (const int version : kCoreVersions) {
      const std::array<int, 9> attributes{OSMESA_FORMAT,
                                          OSMESA_RGBA,
                                          OSMESA_PROFILE,
                                          OSMESA_CORE_PROFILE,
                                          OSMESA_CONTEXT_MAJOR_VERSION,
                                          version / 10,
                                          OSMESA_CONTEXT_MINOR_VERSION,
                                          version % 10,
                                          0};
      handle_ = api_.create(attributes.data(), nullptr);
      if (handle_ != nullptr) break;
    }
    if (handle_ == nullptr) failSystem("OSMesa offers no core profile of 3.3 or higher");
  }
  ~OsmesaContext() override {
    release();
    api_.destroy(handle_);
  }

  void start() {
    makeCurrent();
    describe([this](const char* name) { return reinterpret_cast<void*>(api_.find(name)); });
  }

 protected:
  void bind() override {
    if (!api_.make_current(handle_, picture_.data(), GL_UNSIGNED_BYTE, kSize, kSize))
      failSystem("OSMesa does not make its context current");
  }
  void unbind() noexcept override { api_.make_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }

 private:
  static constexpr int kSize = 4;

  const OsmesaApi api_;
  OSMesaContext handle_ = nullptr;
  // OSMesa wants a picture to draw on; the renderer's own framebuffer leaves it untouched.
  std::array<std::byte, kSize * kSize * 4> picture_{};
};

}  // namespace

std::unique_ptr<GlContext> createOsmesaContext(const GlLibraries& libraries) {
  prepareGlEnvironment();
  auto context =
      std::make_unique<OsmesaContext>(OsmesaApi(SharedLibrary(libraries.osmesa, kInstallOsmesa)));
  context->start();
  return context;
}

}  // namespace sluice
