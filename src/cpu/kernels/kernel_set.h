// Which instruction set a source of kernels is compiled for: each has an object library of its own
// (src/cpu/CMakeLists.txt), so that they are compiled side by side, and a first build needs few of
// them.
//
// SLUICE_KERNEL_SET is one of Highway's targets. Without it, the kernels are those for the
// instructions that the compiler may use anywhere.
#pragma once

// Highway includes a source once for each target; true in its turn.
#ifdef SLUICE_KERNEL_SET
#define SLUICE_HAS_KERNELS (HWY_TARGET == SLUICE_KERNEL_SET && HWY_TARGET != HWY_STATIC_TARGET)
#else
#define SLUICE_HAS_KERNELS (HWY_TARGET == HWY_STATIC_TARGET)
#endif
