// Converts the public headers' options to those of the layers below. Pure functions. All throw
// Error, in one line that names the field, if a value is invalid.
#pragma once

#include <sluice/options.h>
#include <sluice/volume.h>

#include <string>
#include <vector>

#include "io/web/address.h"
#include "src/base/values/picture.h"
#include "src/library/requests.h"
#include "src/render/camera/frame_options.h"

namespace sluice {

VolumeArguments volumeArguments(const std::vector<std::string>& paths,
                                const VolumeOptions& options);
// Sets `open` by the options that are asked for, as far as they say how a file is read. A type that
// is not known is left out.
void setOpen(VolumeArguments& arguments);
// Throws Error, which names the layout's field.
VolumeLayout volumeLayout(const ArrayLayout& array);
// Options without a device, for the pass over a volume.
MachineOptions machineOptions(const VolumeOptions& options);
VolumeOptions::Web webAccess(const BucketAccess& buckets);
MachineOptions machineOptions(const RendererOptions& options);

// `whole_series`: one look for all time steps of the volume.
LookArguments lookArguments(const LookOptions& look, bool whole_series);
// Sets what the look sets, and leaves the rest of the arguments as it is.
void setLook(const LookOptions& look, LookArguments& arguments);
Mode modeOf(const LookOptions& look);
// The look of this mode that sets such arguments.
LookOptions lookOptionsOf(const LookArguments& arguments, Mode mode);

// `framing`, but not `fit`, is the camera's.
Camera cameraOf(const ViewOptions& view);
FitChoice fitChoice(const ViewOptions& view);
// An unset step_vox becomes 1; values that belong to the look are left out. Checks the crop box,
// the time step and the camera against the volume.
FrameOptions frameOptions(const PictureOptions& picture, const VolumeLayout& layout, Mode mode);
// Sets the sampling, the light and the limits, as far as the picture sets them; it needs no volume.
void setDrawing(const PictureOptions& picture, FrameOptions& options);
// The cut through levels of resolution that the picture asks for; unset: level 0 alone.
std::optional<CutOptions> askedCut(const PictureOptions& picture);
// To be called once the mode and the levels to draw are set.
void setPipeline(const PipelineOptions& pipeline, FrameOptions& options);
ViewOptions::Framing framingOf(const Framing& framing);
void requireStep(int64_t time, const VolumeLayout& layout);
// The name as in VolumeInfo::frame.
std::string frameName(WorldFrame frame);

// Tells users sizes in voxels and places in the layout's unit.
VolumeInfo volumeInfo(const VolumeLayout& layout, ValueRange values,
                      const std::vector<std::string>& notes);

}  // namespace sluice
