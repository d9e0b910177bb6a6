#include "src/parallel/part_device.h"

#include <algorithm>

#include "src/base/error.h"

namespace sluice {
namespace {

// Limit for layers that are drawn as pictures of their own.
constexpr size_t kMostPutOffBoxes = 1 << 16;

}  // namespace

PartDevice::PartDevice(std::unique_ptr<Device> device, const Dealing& dealing)
    : device_(std::move(device)), dealing_(dealing) {}

void PartDevice::makeResident(uint64_t id, ChunkTexelsPtr texels) {
  device_->makeResident(id, std::move(texels));
}

void PartDevice::evict(uint64_t id) {
  // Boxes that were put off are still to be drawn from this chunk.
  if (put_off_chunks_.contains(id)) drawPutOff();
  device_->evict(id);
}

void PartDevice::beginFrame(const FrameSetup& setup, const StopToken& stop) {
  setup_ = setup;
  setup_.is_part = !draws_whole_;
  setup_.most_part_bytes = most_bytes_;
  stop_ = stop;
  layers_.emplace(dealing_, setup_);
  put_off_.clear();
  put_off_chunks_.clear();
  taken_ = part_bytes_ = 0;
  part_ = draws_whole_ ? PartialPicture() : emptyPartialPicture(setup.size);
  if (!draws_whole_) spare_ = {};  // a part needs no memory of a picture
  device_->beginFrame(setup_, stop);
}

void PartDevice::draw(std::span<const BoxDraw> boxes) {
  if (draws_whole_) {
    device_->draw(boxes);
    return;
  }
  std::vector<BoxDraw> placed(boxes.begin(), boxes.end());
  if (traitsOf(setup_.mode).needs_order)
    for (BoxDraw& box : placed) box.layer = layers_->layerOf(box.beside.value_or(box.cells));
  if (!goesByLayers()) {
    device_->draw(placed);
    return;
  }
  for (const BoxDraw& box : placed) put_off_chunks_.insert(box.chunk);
  put_off_.insert(put_off_.end(), placed.begin(), placed.end());
  // A layer may then be drawn in several goes. Its records keep their order when they are composed.
  if (put_off_.size() > kMostPutOffBoxes) drawPutOff();
}

void PartDevice::drawPutOff() {
  // Within a layer the boxes keep the order in which the frame drew them.
  std::stable_sort(put_off_.begin(), put_off_.end(),
                   [](const BoxDraw& a, const BoxDraw& b) { return a.layer < b.layer; });
  device_->cancelFrame();  // each layer is a frame of its own
  for (size_t from = 0; from < put_off_.size();) {
    size_t to = from;
    while (to < put_off_.size() && put_off_[to].layer == put_off_[from].layer) ++to;
    device_->beginFrame(setup_, stop_);
    device_->draw(std::span(put_off_).subspan(from, to - from));
    Picture layer = device_->endFrame();
    if (setup_.counts_taken) taken_ += device_->takenSamples();
    takeLayer(put_off_[from].layer, layer);
    device_->reuse(std::move(layer));
    from = to;
  }
  put_off_.clear();
  put_off_chunks_.clear();
}

void PartDevice::takeLayer(uint32_t layer, const Picture& picture) {
  const int channels = partChannels(setup_);
  const ModeTraits& traits = traitsOf(setup_.mode);
  for (size_t tile = 0; tile < part_.tiles.size(); ++tile) {
    const int x0 = static_cast<int>(tile) % part_.across * kPartSide;
    const int y0 = static_cast<int>(tile) / part_.across * kPartSide;
    // Rows of pictures go downwards.
    const auto at = [&](int pixel) {
      const int x = x0 + pixel % kPartSide, y = y0 + pixel / kPartSide;
      return static_cast<size_t>(picture.height - 1 - y) * static_cast<size_t>(picture.width) +
             static_cast<size_t>(x);
    };
    std::vector<std::byte>& records = part_.tiles[tile];
    const size_t before = records.size();
    packPart(
        records, layer, channels,
        [&](int pixel) {
          return x0 + pixel % kPartSide < picture.width &&
                 y0 + pixel / kPartSide < picture.height &&
                 picture.rgba[4 * at(pixel) + traits.telling_number] != traits.first_value;
        },
        [&](int pixel, int channel) {
          const size_t i = at(pixel);
          if (channel < 4) return picture.rgba[4 * i + static_cast<size_t>(channel)];
          // Parts keep depths multiplied by their weights, so that they add up like colours.
          return picture.depth[i] * picture.rgba[4 * i + 3];
        });
    part_bytes_ += records.size() - before;
  }
  checkPartRoom(part_bytes_, most_bytes_);
}

std::vector<float> PartDevice::leastOpacity(const MapGrid& grid) {
  if (draws_whole_) return device_->leastOpacity(grid);
  return std::vector<float>(static_cast<size_t>(grid.side) * static_cast<size_t>(grid.side), 0.0F);
}

void PartDevice::stopOpaque() {
  if (draws_whole_) device_->stopOpaque();
}

uint64_t PartDevice::countSamples(std::span<const BoxDraw> boxes) {
  return device_->countSamples(boxes);
}

uint64_t PartDevice::takenSamples() {
  return goesByLayers() ? taken_ : device_->takenSamples();
}

Picture PartDevice::endFrame() {
  if (draws_whole_) {
    device_->reuse(std::exchange(spare_, {}));
    return device_->endFrame();
  }
  if (goesByLayers()) {
    drawPutOff();
    device_->cancelFrame();
  } else {
    part_ = device_->endPart();
  }
  return {};
}

void PartDevice::cancelFrame() {
  put_off_.clear();
  put_off_chunks_.clear();
  device_->cancelFrame();
}

}  // namespace sluice
