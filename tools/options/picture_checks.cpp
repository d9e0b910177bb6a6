#include "tools/options/picture_checks.h"

#include "src/library/drawing/scene/channel_shares.h"
#include "src/options/option_rules.h"
#include "tools/command_line/usage.h"
#include "tools/options/shared_options.h"

namespace sluice {

void checkPicture(const PictureArguments& picture, const ViewState& view) {
  if (const auto conflict = conflictIn(view)) failUsage("{}", *conflict);
  const ModeTraits traits = traitsOf(picture.frame.mode);
  const bool culls = picture.culling.culling != Culling::kNone;
  if (!picture.look.surfaces.empty() && culls)
    failUsage("--culling knows nothing of surfaces; leave out --culling or --iso");
  if (culls && !traits.hides)
    failUsage("--culling needs --mode composite, since other modes hide nothing");
  if (picture.frame.occlusion != Occlusion::kOff && !traits.hides)
    failUsage("--occlusion needs --mode composite, since other modes hide nothing");
}

void checkPlainOptions(const VolumeArguments& volume, const LookArguments& look,
                       const FrameOptions& frame) {
  if (look.modulate && frame.lighting.looksAround())
    failUsage(
        "--shadows and --occlusion-light need opacities that follow from values alone; leave out "
        "--modulate");
  const VolumeOptions& asked = volume.asked;
  const bool are_several = !asked.over.empty() || asked.channel_name.find(',') != std::string::npos;
  if (!are_several || look.combine != Combine::kBlend) return;
  if (const auto obstacle = blendObstacle(look, frame, {})) failUsage("{}", obstacle->line);
}

std::optional<CutOptions> cutOf(const PictureArguments& picture, bool refines, PictureRow row) {
  if (picture.culling.culling != Culling::kNone) {
    // Culling knows the blocks of the finest level alone.
    refuseLevels(picture.frame.cut, "--culling draws the finest level alone");
    return std::nullopt;
  }
  FrameOptions frame = picture.frame;
  // Pictures that get better begin with any level, also with levels that are made for them. Other
  // modes take levels that are there.
  if (refines && frame.cut && traitsOf(frame.mode).has_colors && !picture.look.labels)
    frame.cut->is_default = false;
  return cutOptions(picture.resources, picture.look, frame, row);
}

}  // namespace sluice
