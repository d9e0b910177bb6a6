#include "src/cpu/simd_target.h"

#include <hwy/highway.h>
#include <hwy/targets.h>

#include <algorithm>

#include "src/base/error.h"
#include "src/cpu/kernel_values.h"

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
uint64_t countSamples(const KernelFrame& frame, const KernelBox* boxes, const uint32_t* indices,
                      size_t count, const TilePixels& tile);
void packetShape(int& width, int& height);
}  // namespace HWY_NAMESPACE

namespace {

struct TargetKernels {
  SimdTarget target;
  int64_t bit;  // Highway's
  Kernels kernels;
};

using DrawTile = decltype(Kernels::composite);

Kernels kernels(const char* name, void (*shape)(int&, int&), DrawTile composite, DrawTile other,
                decltype(Kernels::blended) blended, decltype(Kernels::count) count) {
  Kernels result{name, 1, 1, composite, other, blended, count};
  shape(result.packet_width, result.packet_height);
  return result;
}

#define SLUICE_KERNELS(name, target)                                                  \
  kernels(name, &target::packetShape, &target::drawComposite, &target::drawOtherMode, \
          &target::drawBlended, &target::countSamples)

// Worst first.
const std::vector<TargetKernels>& compiled() {
  static const std::vector<TargetKernels> all = {
    {SimdTarget::kPlain, HWY_STATIC_TARGET, SLUICE_KERNELS("plain", HWY_NAMESPACE)},
#if (HWY_TARGETS & HWY_SSE4) && HWY_STATIC_TARGET != HWY_SSE4 && defined(SLUICE_HAS_SSE4)
    {SimdTarget::kSse4, HWY_SSE4, SLUICE_KERNELS("sse4", N_SSE4)},
#endif
#if (HWY_TARGETS & HWY_AVX2) && HWY_STATIC_TARGET != HWY_AVX2 && defined(SLUICE_HAS_AVX2)
    {SimdTarget::kAvx2, HWY_AVX2, SLUICE_KERNELS("avx2", N_AVX2)},
#endif
#if (HWY_TARGETS & HWY_AVX3) && HWY_STATIC_TARGET != HWY_AVX3 && defined(SLUICE_HAS_AVX3)
    {SimdTarget::kAvx512, HWY_AVX3, SLUICE_KERNELS("avx512", N_AVX3)},
#endif
  };
  return all;
}
#undef SLUICE_KERNELS

bool works(const TargetKernels& each) {
  return each.target == SimdTarget::kPlain || (hwy::SupportedTargets() & each.bit) != 0;
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
  failSystem("--simd {}: this processor, or this build, has no such instructions; give --simd auto",
             name(target));
}

}  // namespace sluice
