#include "src/parallel/rank_share.h"

#include <algorithm>
#include <cstring>

#include "src/base/error.h"
#include "src/device/pictures/partial_picture.h"

namespace sluice {
namespace {

// The share of a rank's memory for parts is 1 / this.
constexpr uint64_t kPartShare = 4;

// The most memory of a tile with so many records of so many pixels together.
uint64_t mostTileBytes(uint64_t pixels, uint64_t records) {
  const uint64_t bytes = pixels * kMostPartChannels * sizeof(float) + records * sizeof(PartHeader);
  return bytes + bytes / kPartGrowth;
}

}  // namespace

uint64_t partBytes(PictureSize size, const Dealing& dealing, uint64_t memory_bytes) {
  // A single rank draws whole pictures, and no parts.
  if (dealing.ranks == 1) return 0;
  if (size.width == 0) return memory_bytes / kPartShare;
  const Vec3i hands = dealing.hands;
  const auto ranks = static_cast<uint64_t>(dealing.ranks);
  // Hands are apart by at most so many steps along the axes, and each step is a layer
  // (DealingLayers).
  const auto layers = static_cast<uint64_t>(hands.x + hands.y + hands.z - 2);
  // In the worst case each layer shows something in each pixel, and all of it is one rank's: a view
  // from close by sees few hands, which are not dealt evenly. A lent box is a layer.
  const uint64_t drawn_layers = dealing.lent ? 1 : layers;
  const uint64_t tiles = emptyPartialPicture(size).tiles.size();
  const uint64_t drawn = tiles * mostTileBytes(drawn_layers * kPartPixels, drawn_layers);
  // A rank composes some tiles, of which it receives what all ranks drew.
  const uint64_t received = (tiles + ranks - 1) / ranks *
                            (layers * kPartPixels * kMostPartChannels * sizeof(float) +
                             ranks * (sizeof(uint64_t) * 2 + drawn_layers * sizeof(PartHeader)));
  const uint64_t composed = tiles * kPartPixels * kMostPartChannels * sizeof(float);
  // Parts are drawn and gathered in turn, and messages exist in addition to them.
  return std::min(memory_bytes / kPartShare, 2 * std::max(drawn, received) + composed);
}

uint64_t memoryOfAnyParts(PictureSize size, const Dealing& dealing) {
  return size.width == 0 ? 0 : kPartShare * partBytes(size, dealing, UINT64_MAX);
}

RankShare::RankShare(Team& team, const Dealing& dealing, WorkerPool& pool, uint64_t part_bytes)
    : team_(team), pool_(pool), part_bytes_(part_bytes), blocks_(dealing, team.rank(), pool) {
  blocks_.tellDealings([this](const Dealing& hands) {
    if (device_ != nullptr) device_->deal(hands);
  });
}

std::unique_ptr<PartDevice> RankShare::deviceFrom(std::unique_ptr<Device> own) {
  auto device = std::make_unique<PartDevice>(std::move(own), blocks_.dealing());
  drawOn(*device);
  return device;
}

void RankShare::drawOn(PartDevice& device) {
  device_ = &device;
  device.deal(blocks_.dealing());
  // The other half is for the parts that come from others, see picture().
  device.limitPart(part_bytes_ / 2);
}

BlockChooser* RankShare::chooserFrom(BlockChooser* chooser) {
  blocks_.chooseFrom(chooser);
  return &blocks_;
}

void RankShare::shareEstimate(CullingOptions& options) {
  // The ranks take the tiles in turn, so that neighbouring tiles, which cost about the same, go to
  // different ranks.
  options.tile_stride = team_.ranks();
  options.first_tile = team_.rank();
  options.exchange = [this](int64_t time, std::vector<bool>& reached) {
    exchangeReached(time, reached);
  };
}

void RankShare::exchangeReached(int64_t time, std::vector<bool>& reached) {
  // The time step goes along: ranks at different ones would mix the blocks of both without a
  // notice.
  Message mine(sizeof time + (reached.size() + 7) / 8);
  std::memcpy(mine.data(), &time, sizeof time);
  for (size_t i = 0; i < reached.size(); ++i)
    if (reached[i]) mine[sizeof time + i / 8] |= std::byte{1} << (i % 8);
  // A block is reached if a ray of any tile reaches it.
  for (const Message& other : team_.gatherAll(mine)) {
    SLUICE_CHECK_EQ(other.size(), mine.size());
    int64_t of = 0;
    std::memcpy(&of, other.data(), sizeof of);
    SLUICE_CHECK_EQ(of, time);
    for (size_t i = 0; i < reached.size(); ++i)
      if ((other[sizeof time + i / 8] >> (i % 8) & std::byte{1}) != std::byte{0}) reached[i] = true;
  }
}

int64_t RankShare::sumOverRanks(int64_t mine) {
  Message message(sizeof mine);
  std::memcpy(message.data(), &mine, sizeof mine);
  int64_t sum = 0;
  for (const Message& other : team_.gatherAll(message)) {
    int64_t number = 0;
    SLUICE_CHECK_EQ(other.size(), sizeof number);
    std::memcpy(&number, other.data(), sizeof number);
    sum += number;
  }
  return sum;
}

Picture RankShare::picture() {
  SLUICE_CHECK(device_ != nullptr);
  report_ = {};
  return composite(team_, device_->takePart(), device_->setup(), pool_, part_bytes_ / 2, report_);
}

}  // namespace sluice
