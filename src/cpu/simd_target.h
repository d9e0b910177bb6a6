// SimdTarget: the instruction set that the CPU device uses. One binary carries the code of all
// targets; the best that the processor has is chosen at run time, and an option holds it to a lower
// one, so that one machine tests all.
#pragma once

#include <array>
#include <string_view>
#include <vector>

namespace sluice {

struct Kernels;  // kernel_values.h

// kAuto is the best that works. kPlain works on any processor (kept for those older than SSE4.1,
// and, on other architectures, for their own instructions).
enum class SimdTarget { kAuto, kPlain, kSse4, kAvx2, kAvx512 };
inline constexpr std::array kSimdTargets = {SimdTarget::kAuto, SimdTarget::kPlain,
                                            SimdTarget::kSse4, SimdTarget::kAvx2,
                                            SimdTarget::kAvx512};

// "auto", "plain", "sse4", "avx2", "avx512".
std::string_view name(SimdTarget target);
// The targets that work on this processor, worst first, without kAuto.
std::vector<SimdTarget> simdTargets();
// Throws Error if the processor lacks it.
const Kernels& kernelsOf(SimdTarget target);

}  // namespace sluice
