// FrameTables: a FrameSetup in the kernels' form; LookUpTables: the tables behind it that frames
// share.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "src/cpu/kernels/kernel_values.h"
#include "src/cpu/kernels/packed_entries.h"
#include "src/device/shading/integrated_look.h"
#include "src/device/shading/look_up_texels.h"

namespace sluice {

// Whether a frame shows one channel, or is one of several that are drawn together. The colours of
// one come from its table alone.
enum class Channels { kOne, kSeveral };

// The tables of a look-up, which many frames share.
struct LookUpTables {
  LookUpTables(LookUpKey of, Channels of_channels);

  LookUpKey key;
  Channels channels;
  std::vector<float> entries;       // see lookUpTexels()
  PackedEntries packed;             // composite that does not interpolate, else without entries
  std::optional<ColorRamp> ramp;    // of `packed`, for frames of several channels
  IntegratedLook integrated;        // pre-integrated frames, else without sums
  std::array<double, 2> visible{};  // visibleValues()
};

class FrameTables {
 public:
  // `look_up` and `light_squares` (light_squares.h; null if there are none), the setup's, must
  // outlive it.
  FrameTables(const FrameSetup& setup, const LookUpTables& look_up,
              const uint64_t* light_squares = nullptr);
  FrameTables(const FrameTables&) = delete;
  FrameTables& operator=(const FrameTables&) = delete;

  const KernelFrame& frame() const { return frame_; }

 private:
  void setRays(const FrameSetup& setup);
  void setLookUp(const LookUpTables& tables);
  void setSurfaces(const LookUp& look_up);
  void setBeside();
  void setLights(const FrameSetup& setup, const uint64_t* light_squares);
  void setRows(const FrameSetup& setup);

  KernelFrame frame_;
  KernelFrame beside_, at_seam_;  // with surfaces
  std::vector<float> row_starts_, row_growths_;
};

}  // namespace sluice
