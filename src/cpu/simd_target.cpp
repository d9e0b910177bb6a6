#include "src/cpu/simd_target.h"

#include <hwy/highway.h>

#include <algorithm>

#include "src/base/error.h"
#include "src/cpu/kernels/kernel_values.h"

namespace sluice {

// Compiled once an instruction set, see kernel_set.h.
#define SLUICE_DECLARE_KERNELS(target)                                                             \
  namespace target {                                                                               \
  void drawComposite(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,    \
                     size_t count, TilePixels& tile);                                              \
  void drawOtherMode(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,    \
                     size_t count, TilePixels& tile);                                              \
  void drawBlended(const KernelFrame* const* frames, size_t channels, const KernelBox* boxes,      \
                   const uint32_t* indices, size_t count, TilePixels& tile);                       \
  void drawAdded(const KernelFrame* const* frames, size_t channels, const KernelBox* boxes,        \
                 const uint32_t* indices, size_t count, TilePixels* tiles);                        \
  uint64_t countSamples(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices, \
                        size_t count, const TilePixels& tile);                                     \
  void packetShape(int& width, int& height);                                                       \
  }
SLUICE_DECLARE_KERNELS(N_SSE4)
SLUICE_DECLARE_KERNELS(N_AVX2)
SLUICE_DECLARE_KERNELS(N_AVX3)
#undef SLUICE_DECLARE_KERNELS
namespace HWY_NAMESPACE {
void drawComposite(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                   size_t count, TilePixels& tile);
void drawOtherMode(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                   size_t count, TilePixels& tile);
void drawBlended(const KernelFrame* const* frames, size_t channels, const KernelBox* boxes,
                 const uint32_t* indices, size_t count, TilePixels& tile);
void drawAdded(const KernelFrame* const* frames, size_t channels, const KernelBox* boxes,
               const uint32_t* indices, size_t count, TilePixels* tiles);
uint64_t countSamples(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                      size_t count, const TilePixels& tile);
void packetShape(int& width, int& height);
}  // namespace HWY_NAMESPACE

namespace {

struct TargetKernels {
  SimdTarget target;
  Kernels kernels;
};

using DrawTile = decltype(Kernels::composite);

Kernels kernels(const char* name, void (*shape)(int&, int&), DrawTile composite, DrawTile other,
                decltype(Kernels::blended) blended, decltype(Kernels::added) added,
                decltype(Kernels::count) count) {
  Kernels result{name, 1, 1, composite, other, blended, added, count};
  shape(result.packet_width, result.packet_height);
  return result;
}

#define SLUICE_KERNELS(name, target)                                                  \
  kernels(name, &target::packetShape, &target::drawComposite, &target::drawOtherMode, \
          &target::drawBlended, &target::drawAdded, &target::countSamples)

// Worst first.
const std::vector<TargetKernels>& compiled() {
  static const std::vector<TargetKernels> all = {
#if defined(SLUICE_HAS_PLAIN)
    {SimdTarget::kPlain, SLUICE_KERNELS("plain", HWY_NAMESPACE)},
#endif
#if (HWY_TARGETS & HWY_SSE4) && HWY_STATIC_TARGET != HWY_SSE4 && defined(SLUICE_HAS_SSE4)
    {SimdTarget::kSse4, SLUICE_KERNELS("sse4", N_SSE4)},
#endif
#if (HWY_TARGETS & HWY_AVX2) && HWY_STATIC_TARGET != HWY_AVX2 && defined(SLUICE_HAS_AVX2)
    {SimdTarget::kAvx2, SLUICE_KERNELS("avx2", N_AVX2)},
#endif
#if (HWY_TARGETS & HWY_AVX3) && HWY_STATIC_TARGET != HWY_AVX3 && defined(SLUICE_HAS_AVX3)
    {SimdTarget::kAvx512, SLUICE_KERNELS("avx512", N_AVX3)},
#endif
  };
  return all;
}
#undef SLUICE_KERNELS

// Whether the processor has the instructions that Highway compiles a set for (HWY_TARGET_STR). Its
// own hwy::SupportedTargets() is in a library that measures a clock for milliseconds when a program
// starts. No processor with BMI2 lacks F16C, for which Clang cannot ask.
bool works(const TargetKernels& each) {
  if (each.target == SimdTarget::kPlain) return true;
#if defined(__x86_64__)
  if (!(__builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("pclmul") &&
        __builtin_cpu_supports("aes")))
    return false;
  if (each.target == SimdTarget::kSse4) return true;
  if (!(__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
        __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2")))
    return false;
  if (each.target == SimdTarget::kAvx2) return true;
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
#else
  return false;
#endif
}

}  // namespace

std::string_view name(SimdTarget target) {
  switch (target) {
    case SimdTarget::kAuto:
      return "auto";
    case SimdTarget::kPlain:
      return "plain";
    case SimdTarget::kSse4:
      return "sse4";
    case SimdTarget::kAvx2:
      return "avx2";
    case SimdTarget::kAvx512:
      break;
  }
  return "avx512";
}

std::vector<SimdTarget> simdTargets() {
  std::vector<SimdTarget> targets;
  for (const TargetKernels& each : compiled())
    if (works(each)) targets.push_back(each.target);
  return targets;
}

const Kernels& kernelsOf(SimdTarget target) {
  const auto& all = compiled();
  for (size_t i = all.size(); i-- > 0;)
    if (works(all[i]) && (target == SimdTarget::kAuto || target == all[i].target))
      return all[i].kernels;
  if (target == SimdTarget::kAuto)
    failSystem(
        "no kernels of the CPU device in this build work on this processor; draw with "
        "--device gl, or build with -DSLUICE_KERNEL_SETS=NATIVE on this processor");
  failSystem("--simd {}: this processor, or this build, has no such instructions; give --simd auto",
             name(target));
}

}  // namespace sluice
