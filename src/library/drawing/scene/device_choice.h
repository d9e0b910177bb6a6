// The choice of the device that draws: --device, --gl and --simd together.
#pragma once

#include <sluice/screen.h>

#include <memory>

#include "src/base/threads/worker_pool.h"
#include "src/cpu/simd_target.h"
#include "src/device/device.h"
#include "src/gl/contexts/gl_choice.h"

namespace sluice {

// kAuto is GL if a GPU's driver works or --gl names a way to it; else the CPU device, which on the
// same processor is faster than software GL.
enum class DeviceChoice { kAuto, kGl, kCpu };

struct DeviceArguments {
  DeviceChoice device = DeviceChoice::kAuto;
  GlChoice gl = GlChoice::kAuto;
  SimdTarget simd = SimdTarget::kAuto;             // for the CPU device
  std::shared_ptr<const ScreenContext> lent = {};  // first choice of GL
};

// `pool`, whose threads the CPU device draws on, must outlive it. Throws Error.
std::unique_ptr<Device> makeDevice(const DeviceArguments& arguments, WorkerPool& pool);

// The limits of that device: a plan needs them and draws nothing. Throws Error.
DeviceLimits limitsOf(const DeviceArguments& arguments, WorkerPool& pool);

// "gl" or "cpu".
const char* nameOf(const Device& device);

}  // namespace sluice
