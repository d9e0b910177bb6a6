#include "src/gl/gl_device.h"
#include "tests/device/suite_device.h"

namespace sluice {

// Software that reads texels one by one, as it is done on hardware that interpolates coarsely.
std::unique_ptr<Device> suiteDevice() {
  return std::make_unique<GlDevice>(createContext(GlChoice::kAuto), true);
}

}  // namespace sluice
