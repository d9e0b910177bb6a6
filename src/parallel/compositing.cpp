#include "src/parallel/compositing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "src/base/error.h"
#include "src/base/threads/clock.h"
#include "src/device/shading/look_up_texels.h"

namespace sluice {
namespace {

// The header before a tile's records in a message.
struct TileHeader {
  uint64_t tile = 0, bytes = 0;
};

void append(Message& to, size_t tile, std::span<const std::byte> records) {
  // Tiles that show nothing cost not even a header.
  if (records.empty()) return;
  const TileHeader header{tile, records.size()};
  const auto* bytes = reinterpret_cast<const std::byte*>(&header);
  to.insert(to.end(), bytes, bytes + sizeof header);
  to.insert(to.end(), records.begin(), records.end());
}

// Calls visit(tile, records) for each tile of a message.
template <class Visit>
void visitTiles(const Message& message, size_t tiles, const Visit& visit) {
  std::span<const std::byte> rest = message;
  while (!rest.empty()) {
    TileHeader header;
    if (rest.size() < sizeof header) failSystem("a message of parts of a picture is cut off");
    std::memcpy(&header, rest.data(), sizeof header);
    rest = rest.subspan(sizeof header);
    if (header.tile >= tiles || header.bytes > rest.size())
      failSystem("a message of parts of a picture is cut off");
    visit(static_cast<size_t>(header.tile), rest.first(header.bytes));
    rest = rest.subspan(header.bytes);
  }
}

// The messages to each owner; `part` is consumed.
std::vector<Message> messagesOf(PartialPicture& part, int ranks) {
  std::vector<Message> to(static_cast<size_t>(ranks));
  std::vector<size_t> sizes(to.size());
  // Sizes come first: a message that grew as it was filled would exist twice at times.
  for (size_t tile = 0; tile < part.tiles.size(); ++tile)
    if (!part.tiles[tile].empty())
      sizes[static_cast<size_t>(ownerOf(tile, ranks))] +=
          part.tiles[tile].size() + sizeof(TileHeader);
  for (size_t r = 0; r < to.size(); ++r) to[r].reserve(sizes[r]);
  for (size_t tile = 0; tile < part.tiles.size(); ++tile) {
    append(to[static_cast<size_t>(ownerOf(tile, ranks))], tile, part.tiles[tile]);
    // The part goes tile by tile as the messages are filled, so that both are never held whole.
    part.tiles[tile] = {};
  }
  return to;
}

std::vector<std::byte> packed(const TileNumbers& numbers, const FrameSetup& setup) {
  std::vector<std::byte> record;
  const ModeTraits& traits = traitsOf(setup.mode);
  packPart(
      record, 0, partChannels(setup),
      [&](int pixel) {
        return numbers[traits.telling_number][static_cast<size_t>(pixel)] != traits.first_value;
      },
      [&](int pixel, int channel) {
        return numbers[static_cast<size_t>(channel)][static_cast<size_t>(pixel)];
      });
  return record;
}

// This rank's tiles, put together.
Message composed(const std::vector<Message>& from, size_t tiles, const FrameSetup& setup,
                 WorkerPool& pool) {
  const int channels = partChannels(setup);
  std::vector<std::vector<PartRecord>> records(tiles);
  for (const Message& message : from)
    visitTiles(message, tiles, [&](size_t tile, std::span<const std::byte> bytes) {
      // The records only refer to the bytes in `from`.
      const std::vector<PartRecord> more = partRecords(bytes, channels);
      records[tile].insert(records[tile].end(), more.begin(), more.end());
    });
  std::vector<std::vector<std::byte>> done(tiles);
  pool.parallelFor(static_cast<int64_t>(tiles), [&](int64_t i) {
    const auto tile = static_cast<size_t>(i);
    if (!records[tile].empty())
      done[tile] = packed(composeTile(std::move(records[tile]), setup), setup);
  });
  Message message;
  for (size_t tile = 0; tile < tiles; ++tile) append(message, tile, done[tile]);
  return message;
}

// Assembles the picture from the finished tiles of all ranks.
Picture pictureOf(const std::vector<Message>& from, const PartialPicture& part,
                  const FrameSetup& setup) {
  const int width = setup.size.width, height = setup.size.height;
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  const int channels = partChannels(setup);
  Picture picture;
  picture.width = width;
  picture.height = height;
  picture.rgba.assign(4 * pixels, 0.0F);
  const ModeTraits& traits = traitsOf(setup.mode);
  if (traits.has_colors && setup.with_depth)
    picture.depth.assign(pixels, std::numeric_limits<float>::infinity());
  if (!traits.has_colors)
    for (size_t i = 0; i < picture.rgba.size(); i += 4) picture.rgba[i] = traits.first_value;
  for (const Message& message : from)
    visitTiles(message, part.tiles.size(), [&](size_t tile, std::span<const std::byte> bytes) {
      // A finished tile is one record, which composing unpacks.
      const TileNumbers numbers = composeTile(partRecords(bytes, channels), setup);
      const int x0 = static_cast<int>(tile) % part.across * kPartSide;
      const int y0 = static_cast<int>(tile) / part.across * kPartSide;
      for (int i = 0; i < kPartPixels; ++i) {
        const int x = x0 + i % kPartSide, y = y0 + i / kPartSide;
        if (x >= width || y >= height) continue;
        const auto pixel = static_cast<size_t>(i);
        // Rows of tiles go upwards, rows of pictures downwards.
        const size_t to = static_cast<size_t>(height - 1 - y) * static_cast<size_t>(width) +
                          static_cast<size_t>(x);
        for (size_t c = 0; c < static_cast<size_t>(std::min(channels, 4)); ++c)
          picture.rgba[4 * to + c] = numbers[c][pixel];
        // The sum of weights times depths, over the sum of weights, which is the opacity.
        if (!picture.depth.empty() && numbers[3][pixel] > 0)
          picture.depth[to] = numbers[4][pixel] / numbers[3][pixel];
      }
    });
  // Numbers of these modes become colours here and not before: colours of parts cannot be combined.
  if (!traits.has_colors) resolveMode(setup, 1, picture.rgba);
  return picture;
}

uint64_t bytesOfOthers(const std::vector<Message>& messages, int rank) {
  uint64_t sum = 0;
  for (size_t r = 0; r < messages.size(); ++r)
    if (r != static_cast<size_t>(rank)) sum += messages[r].size();
  return sum;
}

}  // namespace

CompositingReport& CompositingReport::operator+=(const CompositingReport& more) {
  part_bytes += more.part_bytes;
  sent_bytes += more.sent_bytes;
  received_bytes += more.received_bytes;
  exchange_seconds += more.exchange_seconds;
  compose_seconds += more.compose_seconds;
  gather_seconds += more.gather_seconds;
  return *this;
}

int ownerOf(size_t tile, int ranks) {
  return static_cast<int>(tile % static_cast<size_t>(ranks));
}

Picture composite(Team& team, PartialPicture part, const FrameSetup& setup, WorkerPool& pool,
                  uint64_t most_bytes, CompositingReport& report) {
  Stopwatch watch;
  report.part_bytes = part.bytes();
  std::vector<Message> to = messagesOf(part, team.ranks());
  report.sent_bytes = bytesOfOthers(to, team.rank());
  std::vector<Message> from = team.exchange(std::move(to), most_bytes);
  report.received_bytes = bytesOfOthers(from, team.rank());
  report.exchange_seconds = watch.lap();
  Message mine = composed(from, part.tiles.size(), setup, pool);
  // The parts that came are freed before the finished tiles come.
  from.clear();
  report.compose_seconds = watch.lap();
  const std::vector<Message> tiles = team.gather(std::move(mine));
  Picture picture;
  if (team.isFirst()) picture = pictureOf(tiles, part, setup);
  report.gather_seconds = watch.lap();
  return picture;
}

}  // namespace sluice
