#include "tests/device/suite_device.h"
#include "tests/support/plain_device.h"

namespace sluice {

std::unique_ptr<Device> suiteDevice() {
  return std::make_unique<PlainDevice>();
}

}  // namespace sluice
