#include "src/device/pictures/partial_picture.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/base/values/bytes.h"

namespace sluice {
namespace {

// Calls visit(pixel, numbers) for each pixel of a record.
template <class Visit>
void visitPixels(const PartRecord& record, int channels, const Visit& visit) {
  std::array<float, kMostPartChannels> numbers{};
  const size_t bytes = static_cast<size_t>(channels) * sizeof(float);
  const std::byte* from = record.numbers.data();
  for (size_t word = 0; word < record.header.mask.size(); ++word)
    for (uint64_t left = record.header.mask[word]; left != 0; left &= left - 1, from += bytes) {
      std::memcpy(numbers.data(), from, bytes);
      visit(word * 64 + static_cast<size_t>(std::countr_zero(left)), numbers);
    }
}

}  // namespace

uint64_t PartialPicture::bytes() const {
  uint64_t sum = 0;
  for (const std::vector<std::byte>& tile : tiles) sum += tile.capacity();
  return sum;
}

void checkPartRoom(uint64_t bytes, uint64_t most_bytes) {
  if (bytes <= most_bytes) return;
  failMemory(
      "a part of the picture takes {}, --memory leaves {} to it; give more --memory or a smaller "
      "--size",
      formatBytes(bytes), formatBytes(most_bytes));
}

PartialPicture emptyPartialPicture(PictureSize size) {
  PartialPicture picture;
  picture.across = (size.width + kPartSide - 1) / kPartSide;
  picture.up = (size.height + kPartSide - 1) / kPartSide;
  picture.tiles.resize(static_cast<size_t>(picture.across) * static_cast<size_t>(picture.up));
  return picture;
}

std::vector<PartRecord> partRecords(std::span<const std::byte> tile, int channels) {
  std::vector<PartRecord> records;
  while (!tile.empty()) {
    PartRecord record;
    if (tile.size() < sizeof record.header) failSystem("a part of a picture is cut off");
    std::memcpy(&record.header, tile.data(), sizeof record.header);
    tile = tile.subspan(sizeof record.header);
    uint32_t pixels = 0;
    for (const uint64_t word : record.header.mask)
      pixels += static_cast<uint32_t>(std::popcount(word));
    const size_t bytes = size_t{pixels} * static_cast<size_t>(channels) * sizeof(float);
    // The mask is compared with its count, so that a message that was cut off or mixed up is found
    // here.
    if (pixels != record.header.pixels || tile.size() < bytes)
      failSystem("a part of a picture is cut off");
    record.numbers = tile.first(bytes);
    tile = tile.subspan(bytes);
    records.push_back(record);
  }
  return records;
}

TileNumbers composeTile(std::vector<PartRecord> records, const FrameSetup& setup) {
  TileNumbers tile{};
  const int channels = partChannels(setup);
  const ModeTraits& traits = traitsOf(setup.mode);
  if (traits.needs_order) {
    // Records of one layer keep their order, in which their maker drew them.
    std::stable_sort(records.begin(), records.end(), [](const PartRecord& a, const PartRecord& b) {
      return a.header.layer < b.header.layer;
    });
    for (const PartRecord& record : records)
      visitPixels(record, channels, [&](size_t pixel, const auto& numbers) {
        if (traits.combining == Combining::kAttenuated) {
          // Number 1 is the opacity of the layers in front, which dims the values of this one.
          const float clear = 1 - tile[1][pixel];
          tile[0][pixel] = std::max(tile[0][pixel], clear * numbers[0]);
          tile[1][pixel] += clear * numbers[1];
          tile[2][pixel] = std::max(tile[2][pixel], numbers[2]);
          return;
        }
        // Layers are blended front to back, premultiplied (Porter-Duff's "over"); depths times
        // weights blend as colours do.
        const float through = 1 - tile[3][pixel];
        for (size_t c = 0; c < static_cast<size_t>(channels); ++c)
          tile[c][pixel] += through * numbers[c];
      });
    return tile;
  }
  // The numbers follow resolveMode(): of a minimum, both are the least.
  tile[0].fill(traits.first_value);
  tile[1].fill(traits.first_value);
  for (const PartRecord& record : records)
    visitPixels(record, channels, [&](size_t pixel, const auto& numbers) {
      for (size_t c = 0; c < 2; ++c) {
        float& to = tile[c][pixel];
        if (traits.combining == Combining::kGreatest) to = std::max(to, numbers[c]);
        if (traits.combining == Combining::kLeast) to = std::min(to, numbers[c]);
        if (traits.combining == Combining::kSum) to += numbers[c];
      }
    });
  return tile;
}

}  // namespace sluice
