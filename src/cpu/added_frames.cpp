// The CPU device's sums of frames, see AddsFrames: a tile of all frames after another.
#include <algorithm>
#include <array>
#include <atomic>
#include <utility>

#include "src/base/error.h"
#include "src/cpu/added_boxes.h"
#include "src/cpu/cpu_device.h"

namespace sluice {

void CpuDevice::beginSum() {
  SLUICE_CHECK(!sum_);
  sum_.emplace();
}

void CpuDevice::cancelSum() {
  sum_.reset();
  put_off_.clear();
  put_off_samples_ = 0;
  for (auto& [id, chunk] : resident_) chunk.is_put_off = false;
}

AddsFrames::Sum CpuDevice::endSum(float least_opacity) {
  AddedFrames frames = *std::exchange(sum_, std::nullopt);
  const size_t channels = frames.setups.size();
  SLUICE_CHECK(channels > 0);
  FrameSetup all = std::move(frames.setups.front());
  all.others.assign(std::move_iterator(frames.setups.begin() + 1),
                    std::move_iterator(frames.setups.end()));
  beginFrame(all, stop_);
  put_off_ = joinAlike(frames.boxes);
  for (const BoxDraw& box : put_off_) resident_.at(box.chunk).is_put_off = true;
  if (leaps_) prepareLeaps();
  const std::vector<KernelBox> boxes = kernelBoxes();
  forgetPutOff();
  const TileBins bins = binsOf(boxes);
  Sum sum{std::exchange(spare_, {}), {}};
  picture_.shape(sum.picture, stop_);
  std::array<std::atomic<bool>, kMostBlended> shows{};
  eachTile(pool_, picture_.tiles(), [&](int64_t index) {
    std::span<const uint32_t> rest = bins.of(index);
    if (rest.empty()) return picture_.copyTile(picture_.drawnTile(index), sum.picture);
    // The tiles of all channels stay in the processor's second cache.
    std::array<TiledPicture::Scratch, kMostBlended> scratch;
    std::array<TilePixels, kMostBlended> tiles;
    for (size_t c = 0; c < channels; ++c) tiles[c] = picture_.tile(index, scratch[c]);
    for (stop_.throwIfStopped(); !rest.empty(); stop_.throwIfStopped()) {
      const auto part = rest.first(std::min(kBoxesBetweenStops, rest.size()));
      kernels_.added(drawing_.frames.data(), channels, boxes.data(), part.data(), part.size(),
                     tiles.data());
      rest = rest.subspan(part.size());
    }
    for (size_t c = 0; c < channels; ++c)
      if (!shows[c] && picture_.shows(tiles[c], least_opacity)) shows[c] = true;
    for (size_t c = 1; c < channels; ++c)
      for (size_t color = 0; color < tiles[c].color.size(); ++color)
        for (int i = 0; i < kTilePixels; ++i) tiles[0].color[color][i] += tiles[c].color[color][i];
    picture_.copyTile(tiles[0], sum.picture);
  });
  stop_.throwIfStopped();
  sum.shows.assign(shows.begin(), shows.begin() + static_cast<ptrdiff_t>(channels));
  return sum;
}

}  // namespace sluice
