// The CPU device of tests, with threads of its own.
#pragma once

#include <memory>

#include "src/cpu/cpu_device.h"

namespace sluice {

struct TestThreads {
  WorkerPool test_pool{3};
};

class TestCpuDevice : private TestThreads, public CpuDevice {
 public:
  explicit TestCpuDevice(SimdTarget target = SimdTarget::kAuto)
      : CpuDevice(TestThreads::test_pool, target) {}
};

}  // namespace sluice
