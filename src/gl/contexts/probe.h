// probeGl: which ways to OpenGL work on this machine and why the others do not, for `sluice
// doctor`.
//
// Each way is tried in a process of its own with a time limit (child_process.h), so that a driver
// that crashes or hangs costs an entry in the list and not the program; nothing is printed. Call it
// before this process makes a context and before it starts threads.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "src/gl/contexts/context.h"

namespace sluice {

struct GlProbe {
  std::string backend;  // "osmesa" or "egl"
  // With EGL: a device ("/dev/dri/card0", "device 1 (software)"), "surfaceless" or "default
  // display".
  std::string device;
  bool works = false;
  bool is_software = false;
  std::string renderer, version;  // GL_RENDERER and GL_VERSION if it works
  int max_3d_texture_size = 0;    // 0 if it does not work
  std::string reason;             // why it does not work
};

// OSMesa, each EGL device, EGL surfaceless, EGL on the default display, in this order. One "egl"
// entry with the reason if libEGL itself does not open. Throws Error only when the system gives no
// process.
std::vector<GlProbe> probeGl(const GlLibraries& libraries = {},
                             std::chrono::milliseconds timeout = std::chrono::seconds(20));

}  // namespace sluice
