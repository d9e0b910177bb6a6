#include "src/library/drawing/scene/device_choice.h"

#include <string_view>

#include "src/base/error.h"
#include "src/cpu/cpu_device.h"
#if SLUICE_HAS_GL
#include "src/gl/contexts/lent_context.h"
#include "src/gl/gl_device.h"
#endif

namespace sluice {
namespace {

#if SLUICE_HAS_GL
// Null if the CPU device is to draw.
std::unique_ptr<GlContext> contextFor(const DeviceArguments& arguments) {
  if (arguments.device == DeviceChoice::kCpu) return nullptr;
  if (arguments.lent != nullptr)
    return createLentContext(
        {arguments.lent->make_current, arguments.lent->release, arguments.lent->find});
  if (arguments.device == DeviceChoice::kGl || arguments.gl != GlChoice::kAuto)
    return createContext(arguments.gl);
  return createHardwareContext();
}
#endif

}  // namespace

std::unique_ptr<Device> makeDevice(const DeviceArguments& arguments, WorkerPool& pool) {
#if SLUICE_HAS_GL
  if (auto context = contextFor(arguments)) return std::make_unique<GlDevice>(std::move(context));
#else
  if (arguments.device == DeviceChoice::kGl || arguments.gl != GlChoice::kAuto)
    failSystem("this sluice was built without OpenGL (SLUICE_GL=OFF); give --device cpu");
#endif
  return std::make_unique<CpuDevice>(pool, arguments.simd);
}

DeviceLimits limitsOf(const DeviceArguments& arguments, WorkerPool& pool) {
  return makeDevice(arguments, pool)->limits();
}

const char* nameOf(const Device& device) {
  return std::string_view(device.backend()) == "cpu" ? "cpu" : "gl";
}

}  // namespace sluice
