#include "src/gl/contexts/probe.h"

#include <functional>
#include <sstream>

#include "src/base/error.h"
#include "src/gl/contexts/backends.h"
#include "src/gl/contexts/child_process.h"

namespace sluice {
namespace {

using Create = std::function<std::unique_ptr<GlContext>()>;

// The answer of a child: a line a field.
std::string ask(const Create& create) {
  const auto context = create();
  return fmt::format("{}\n{}\n{}\n{}\n", context->renderer(), context->version(),
                     context->isSoftware() ? 1 : 0, context->limits().max_3d_texture_size);
}

GlProbe probe(std::string backend, std::string device, const Create& create,
              std::chrono::milliseconds timeout) {
  GlProbe result;
  result.backend = std::move(backend);
  result.device = std::move(device);
  const ChildAnswer child = runInChild([&] { return ask(create); }, timeout);
  result.works = child.answered;
  result.reason = child.reason;
  if (!result.works) return result;
  std::istringstream lines(child.answer);
  std::getline(lines, result.renderer);
  std::getline(lines, result.version);
  lines >> result.is_software >> result.max_3d_texture_size;
  return result;
}

// The devices' names, a line each.
std::string listDevices(const GlLibraries& libraries) {
  std::string lines;
  for (const EglDevice& device : listEglDevices(libraries)) lines += device.name + "\n";
  return lines;
}

}  // namespace

std::vector<GlProbe> probeGl(const GlLibraries& libraries, std::chrono::milliseconds timeout) {
  std::vector<GlProbe> result;
  result.push_back(probe(
      "osmesa", "", [&] { return createOsmesaContext(libraries); }, timeout));
  const ChildAnswer devices = runInChild([&] { return listDevices(libraries); }, timeout);
  if (!devices.answered) {
    GlProbe& egl = result.emplace_back();
    egl.backend = "egl";
    egl.reason = devices.reason;
    return result;
  }
  const auto probeEgl = [&](std::string name, EglTarget target) {
    result.push_back(probe(
        "egl", std::move(name), [&, target] { return createEglContext(libraries, target); },
        timeout));
  };
  std::istringstream lines(devices.answer);
  int index = 0;
  for (std::string name; std::getline(lines, name); ++index)
    probeEgl(name, {EglPlatform::kDevice, index});
  probeEgl("surfaceless", {EglPlatform::kSurfaceless});
  probeEgl("default display", {EglPlatform::kDefault});
  return result;
}

}  // namespace sluice
