#include "tests/device/suite_device.h"

#include "tests/gl/test_device.h"

namespace sluice {

std::unique_ptr<Device> suiteDevice() {
  return testDevice();
}

}  // namespace sluice
