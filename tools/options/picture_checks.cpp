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
    refuseLevels(picture.levels, "--culling draws the finest level alone");
    return std::nullopt;
  }
  LevelArguments levels = picture.levels;
  // Pictures that get better begin with any level, also with levels that are made for them. Other
  // modes take levels that are there.
  if (refines && !levels.level && traitsOf(picture.frame.mode).has_colors && !picture.look.labels)
    levels.pixel_error = levels.pixel_error.value_or(CutOptions().pixel_error);
  return cutOptions(levels, picture.resources, picture.look, picture.frame, row);
}

}  // namespace sluice
