// FrameTables: a FrameSetup as the kernels take it, with the tables that it points to.
#pragma once

#include <vector>

#include "src/cpu/kernel_values.h"
#include "src/cpu/packed_entries.h"

namespace sluice {

class FrameTables {
 public:
  explicit FrameTables(const FrameSetup& setup);
  FrameTables(const FrameTables&) = delete;
  FrameTables& operator=(const FrameTables&) = delete;

  const KernelFrame& frame() const { return frame_; }

 private:
  void setRays(const FrameSetup& setup);
  void setLookUp(const FrameSetup& setup);
  void setLights(const FrameSetup& setup);
  void setRows(const FrameSetup& setup);

  KernelFrame frame_;
  PackedEntries packed_;
  std::vector<float> entries_, factors_, row_starts_, row_growths_;
};

}  // namespace sluice
