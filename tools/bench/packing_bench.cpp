// sluice bench packing: the gain from compressing a volume's blocks in memory, by codec.
#include <fmt/format.h>

#include <array>

#include "src/base/threads/clock.h"
#include "src/volume/packed_block.h"
#include "src/volume/volume_buffer.h"
#include "tools/bench/bench.h"
#include "tools/command_line/console.h"
#include "tools/scene/open_scene.h"
#include "tools/scene/workers.h"

namespace sluice {
namespace {

constexpr std::array kCodecs = {
    PackCodec{"lz4", 1},  PackCodec{"lz4", 5},  PackCodec{"lz4hc", 5}, PackCodec{"blosclz", 5},
    PackCodec{"zlib", 1}, PackCodec{"zstd", 1}, PackCodec{"zstd", 3}};
constexpr uint64_t kMostPackedBytes = uint64_t{64} << 20;

nlohmann::json rowOf(const std::vector<VolumeBlockPtr>& blocks, const PackCodec& codec) {
  uint64_t whole_bytes = 0, kept_bytes = 0, unpacked_bytes = 0;
  double pack_seconds = 0, unpack_seconds = 0;
  std::vector<std::byte> out;
  for (const VolumeBlockPtr& block : blocks) {
    const std::span<const std::byte> voxels(block->bytes.get(), block->byteCount());
    Stopwatch watch;
    const std::optional<PackedBytes> packed = pack(voxels, bytesPerVoxel(block->type), codec);
    pack_seconds += watch.lap();
    whole_bytes += voxels.size();
    kept_bytes += packed ? packed->byte_count : voxels.size();
    if (!packed) continue;
    out.resize(voxels.size());
    // Memory for the result is not part of unpacking.
    watch.lap();
    unpack(*packed, out);
    unpack_seconds += watch.lap();
    unpacked_bytes += voxels.size();
  }
  return {{"codec", codec.name},
          {"level", codec.level},
          {"ratio", static_cast<double>(whole_bytes) / static_cast<double>(kept_bytes)},
          {"pack_bytes_per_second", static_cast<double>(whole_bytes) / pack_seconds},
          {"unpack_bytes_per_second",
           unpacked_bytes == 0 ? 0 : static_cast<double>(unpacked_bytes) / unpack_seconds}};
}

// {"rows": [{"codec", "level", "ratio", "pack_bytes_per_second", "unpack_bytes_per_second"}]}, on
// one thread, over blocks that are not one value, at most 64 MiB of them. Throws Error.
nlohmann::json benchPacking(const VolumeArguments& arguments, const ResourceArguments& resources) {
  Workers pool(resources.threads);
  const IndexedVolume volume = openIndexed(arguments, resources, {}, pool);
  VolumeBuffer buffer(*volume.source, volume.layout, 2 * kMostPackedBytes);
  const std::vector<int64_t>& ids = volume.index->ranges.blocks;
  // Spread over the volume, if it has more blocks than are measured.
  const size_t most = std::max<size_t>(1, kMostPackedBytes / buffer.blockBytes());
  const size_t stride = std::max<size_t>(1, ids.size() / most);
  std::vector<VolumeBlockPtr> blocks;
  for (size_t i = 0; i < ids.size() && blocks.size() < most; i += stride) {
    const BlockName key{.time = arguments.time, .block = ids[i]};
    blocks.push_back(buffer.acquire(std::span(&key, 1)).front());
  }
  nlohmann::json report{{"blocks", blocks.size()}, {"rows", nlohmann::json::array()}};
  for (const PackCodec& codec : kCodecs) report["rows"].push_back(rowOf(blocks, codec));
  return report;
}

void printPacking(const nlohmann::json& report) {
  say("{:<12} {:>7} {:>12} {:>14}\n", "codec", "ratio", "packs MB/s", "unpacks MB/s");
  for (const auto& row : report["rows"])
    say("{:<12} {:>7.2f} {:>12.0f} {:>14.0f}\n",
        fmt::format("{}-{}", row["codec"].get<std::string>(), row["level"].get<int>()),
        row["ratio"].get<double>(), row["pack_bytes_per_second"].get<double>() / 1e6,
        row["unpack_bytes_per_second"].get<double>() / 1e6);
}

}  // namespace

Bench addPackingBench(CLI::App& app) {
  auto bench = std::make_shared<BenchArguments>();
  CLI::App* packing = app.add_subcommand(
      "packing", "Measures compression of a volume's blocks in memory, by codec, on one core");
  addVolumeOptions(*packing, bench->volume);
  addReadingOptions(*packing, bench->resources);
  takeIdleOptions(*packing);
  return {packing, [bench](const Show& show) {
            return show(benchPacking(bench->volume, bench->resources), printPacking);
          }};
}

}  // namespace sluice
