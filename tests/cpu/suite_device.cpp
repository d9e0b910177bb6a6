#include "tests/device/suite_device.h"

#include "tests/cpu/test_device.h"

namespace sluice {

std::unique_ptr<Device> suiteDevice() {
  return std::make_unique<TestCpuDevice>();
}

}  // namespace sluice
