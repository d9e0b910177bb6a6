// One set of rules for `render`, which draws pictures, and `plan`, which forecasts them: it refuses
// options that exclude each other, and decides how a picture is cut into levels.
#pragma once

#include <optional>

#include "src/library/drawing/scene/resources.h"
#include "src/options/view_state.h"
#include "tools/options/arguments.h"

namespace sluice {

// The options of a picture; `frame.cut` is the cut that is asked for (addLevelOptions()).
struct PictureArguments {
  const LookArguments& look;
  const FrameOptions& frame;
  const CullingArguments& culling;
  const ResourceArguments& resources;
};

// Throws a usage error for options that exclude each other: those of the view, for which there are
// rules (src/options/option_rules.h), and those that commands alone have.
void checkPicture(const PictureArguments& picture, const ViewState& view);

// Throws a usage error for further options that no volume lets go together. To be called without a
// saved view, since one that has them is at fault itself.
void checkPlainOptions(const VolumeArguments& volume, const LookArguments& look,
                       const FrameOptions& frame);

// The cut through levels of resolution that a picture is drawn from; nullopt: the finest level
// alone. `refines`: the first of pictures that get better, each of which may begin with any level.
// Throws a usage error for options of levels if the picture needs the finest one.
std::optional<CutOptions> cutOf(const PictureArguments& picture, bool refines, PictureRow row);

}  // namespace sluice
