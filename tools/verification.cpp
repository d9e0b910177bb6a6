#include "tools/verification.h"

#include <algorithm>
#include <cmath>

namespace sluice {

Verification verify(Scene& scene, FrameOptions options, const Picture& picture) {
  options.algorithm = Algorithm::kConventional;
  options.partition = Partition::kBlocks;
  options.opacity_threshold = 1;
  options.occlusion = Occlusion::kOff;
  options.count_samples = false;
  options.keep_phases = false;
  if (scene.share) scene.share->device().drawWhole(true);
  scene.session->chooseBlocksBy(nullptr);
  scene.session->setOptions(options);
  const Picture plain = scene.session->frame().picture;
  Verification result;
  double sum = 0;
  for (size_t i = 0; i < plain.rgba.size(); ++i) {
    const double a = std::clamp(plain.rgba[i], 0.0F, 1.0F),
                 b = std::clamp(picture.rgba[i], 0.0F, 1.0F);
    const double difference = 255 * std::abs(a - b);
    result.max_difference = std::max(result.max_difference, difference);
    sum += difference;
  }
  result.mean_difference = sum / static_cast<double>(plain.rgba.size());
  return result;
}

}  // namespace sluice
