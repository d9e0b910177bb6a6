// Voxels for people: the value at a place, the first thing that a ray meets, slices. All read
// through level 2 of the session, within its budget, on the thread that draws.
#pragma once

#include <sluice/options.h>
#include <sluice/report.h>

#include <optional>
#include <vector>

#include "src/base/threads/stop_token.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/device/frame_values.h"
#include "src/render/session/session.h"

namespace sluice {

// A ray through a picture, for finding what it meets.
struct ProbeRequest {
  const FrameOptions& options;  // crop, clip planes and mode; the camera is resolved in `view`
  const View& view;
  const TransferFunction& transfer;
  double right = 0.5, down = 0.5;  // 0 to 1, of the picture
};

// See Renderer::probe(). Throws Error from the source, Interrupted.
std::optional<VoxelProbe> probeAlong(const ProbeRequest& request, Session& session,
                                     const TimeStep& step, const StopToken& stop);

// See Renderer::slice(). Throws Error: no such axis or plane; from the source; Interrupted.
SliceValues sliceOf(const SliceOptions& slice, Session& session, const TimeStep& step,
                    const StopToken& stop);

}  // namespace sluice
