// The ways to a context, one call each; createContext (context.h) and probeGl (probe.h) choose
// among them. Internal to src/gl. All throw Error with the reason and leave the new context
// current.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "src/gl/contexts/context.h"

namespace sluice {

// Asked for from the highest on: a library need not give more than the version requested.
inline constexpr std::array kCoreVersions{46, 45, 44, 43, 42, 41, 40, 33};

// Sets the environment variables that context.h explains. Idempotent; called before a library
// opens.
void prepareGlEnvironment();

// Throws Error: the library does not open, or gives no context of any of kCoreVersions.
std::unique_ptr<GlContext> createOsmesaContext(const GlLibraries& libraries);

struct EglDevice {
  std::string name;  // "/dev/dri/card0", "device 1", "device 0 (software)"
  bool is_software = false;
};
// In the order of the library; empty if it cannot enumerate devices. Throws Error when libEGL does
// not open.
std::vector<EglDevice> listEglDevices(const GlLibraries& libraries);

enum class EglPlatform { kDevice, kSurfaceless, kDefault };
struct EglTarget {
  EglPlatform platform = EglPlatform::kDevice;
  int device = 0;  // index in listEglDevices, for kDevice
};
std::unique_ptr<GlContext> createEglContext(const GlLibraries& libraries, EglTarget target);

}  // namespace sluice
