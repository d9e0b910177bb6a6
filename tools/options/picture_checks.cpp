#include "tools/options/picture_checks.h"

#include <utility>

#include "src/base/error.h"
#include "tools/options/shared_options.h"

namespace sluice {

void checkPicture(const PictureArguments& picture) {
  const ModeTraits traits = traitsOf(picture.frame.mode);
  const bool looks_around = picture.frame.lighting.looksAround();
  const bool culls = picture.culling.culling != Culling::kNone;
  if (!picture.look.surfaces.empty() && !traits.has_colors)
    fail("--iso needs --mode composite, since other modes show one value a pixel");
  if (looks_around && !traits.has_colors)
    fail("--shadows and --occlusion-light need --mode composite, since other modes are not lit");
  if (looks_around && picture.look.no_shade)
    fail("--shadows and --occlusion-light light the picture; leave out --no-shade");
  if (!traits.has_colors)
    for (const auto& [value, option] : {std::pair(picture.frame.depth_cueing, "--depth-cueing"),
                                        std::pair(picture.frame.jitter, "--jitter")})
      if (value > 0) fail("{} needs --mode composite", option);
  if (!picture.look.surfaces.empty() && culls)
    fail("--culling knows nothing of surfaces; leave out --culling or --iso");
  if (culls && !traits.hides)
    fail("--culling needs --mode composite, since other modes hide nothing");
  if (picture.frame.occlusion != Occlusion::kOff && !traits.hides)
    fail("--occlusion needs --mode composite, since other modes hide nothing");
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
