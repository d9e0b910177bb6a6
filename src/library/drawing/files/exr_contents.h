// The contents of an OpenEXR file of a picture: its values in linear light, and header attributes
// that reproduce it and place it in a scene. A pure function.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "io/pictures/exr_file.h"
#include "src/base/sources/volume_source.h"
#include "src/classify/transfer/transfer_function.h"
#include "src/render/camera/frame_options.h"

namespace sluice {

// The inputs that the picture was drawn from.
struct DrawnOf {
  const FrameOptions& options;
  const VolumeSource& source;
  const TransferFunction& transfer;
  const std::string& look;  // options of `sluice render` that give it, see ChosenLook
};

// Only the pixels, of some rows of a picture: over the background if there is one. `with_opacity`:
// also the volume's own opacity, in a channel "opacity".
ExrContents exrRows(const Picture& rows, const std::optional<std::array<float, 3>>& background,
                    bool with_opacity);
// The same with the header of the file.
ExrContents exrContents(const Picture& picture,
                        const std::optional<std::array<float, 3>>& background, bool with_opacity,
                        const DrawnOf& of);

}  // namespace sluice
