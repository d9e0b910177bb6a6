// The device of tests: software GL, whose pictures are the same everywhere.
#pragma once

#include <memory>

#include "src/base/error.h"
#include "src/gl/gl_device.h"

namespace sluice {

// OSMesa's, or EGL's if it is missing. Throws Error if neither works.
inline std::unique_ptr<GlDevice> testDevice() {
  try {
    return std::make_unique<GlDevice>(createContext(GlChoice::kOsmesa));
  } catch (const Error&) {
    return std::make_unique<GlDevice>(createContext(GlChoice::kEgl));
  }
}

}  // namespace sluice
