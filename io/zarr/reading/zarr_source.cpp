#include "io/zarr/reading/zarr_source.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "io/files/copy_row.h"
#include "io/files/swap_bytes.h"
#include "io/stores/folder_store.h"
#include "io/zarr/metadata/zarr_folder.h"
#include "io/zarr/reading/zarr_codec.h"
#include "io/zarr/reading/zarr_levels.h"
#include "io/zarr/reading/zarr_rows.h"
#include "src/base/error.h"

namespace sluice {

namespace fs = std::filesystem;

namespace {

constexpr uint64_t kSmallChunkBytes = 4 << 20;

LevelClaim claimOf(const ZarrView& view, const ZarrImage& image, size_t dataset) {
  LevelClaim claim;
  claim.dims = view.layout.dims;
  const ZarrPlace& place = image.places[dataset];
  if (place.scale.empty()) return claim;
  claim.scale = claim.translation = Vec3d{};
  for (size_t a = 0; a < 3; ++a) {
    (*claim.scale)[static_cast<int>(a)] = place.scale[view.space[a]];
    (*claim.translation)[static_cast<int>(a)] = place.translation[view.space[a]];
  }
  return claim;
}

// Why two arrays cannot be levels of one image; empty if they can.
std::string faultAmong(const VolumeLayout& finest, const VolumeLayout& level) {
  if (level.type != finest.type)
    return fmt::format("its voxels are {}, the first level's are {}", name(level.type),
                       name(finest.type));
  if (level.time_steps != finest.time_steps || level.channels != finest.channels)
    return fmt::format("it has {} time steps and {} channels, the first level {} and {}",
                       level.time_steps, level.channels, finest.time_steps, finest.channels);
  return "";
}

// Why an array cannot be the spreads of a level; empty where it can.
std::string faultOfSpreads(const VolumeLayout& level, const VolumeLayout& spreads) {
  const VoxelType type = spreadType(level.type);
  if (spreads.type != type)
    return fmt::format("its numbers are {}, expected {}", name(spreads.type), name(type));
  if (spreads.dims != level.dims || spreads.time_steps != level.time_steps ||
      spreads.channels != level.channels)
    return "its shape is not that of the level";
  return "";
}

}  // namespace

ZarrSource::ZarrSource(const fs::path& folder, const ZarrOptions& options)
    : ZarrSource(folderPlace(folder), options) {}

ZarrSource::ZarrSource(const StorePlace& folder, const ZarrOptions& options)
    : ZarrSource(folder, findZarr(folder), options.channel,
                 std::make_shared<ZarrChunkCache>(options.chunk_cache_bytes), Part::kImage) {}

ZarrSource::~ZarrSource() = default;

ZarrSource::ZarrSource(const StorePlace& folder, FoundZarr found, const ChannelWish& channel,
                       std::shared_ptr<ZarrChunkCache> cache, Part part)
    : cache_(std::move(cache)), part_(part) {
  const ZarrHeader header = readArrayHeader(found.array_folder);
  found.take(header);
  ZarrArray array = parseZarrArray(header.text, header.path);
  view_ = viewZarr(array, found.image, channel.given(), found.said_by);
  view_.layout.name = folder.lastPart() + (found.image.level_set ? " (level set)" : "");
  if (channel.given() && !view_.channel)
    fail("{}: --channel {}: the volume has no channels; leave it out", folder.name(),
         channel.text());
  channel_names_ = found.image.channels;
  for (const std::string& note : array.notes) view_.layout.notes.push_back(note);
  chooseChannel(folder.name(), channel, channel_names_, view_.layout);
  channel_ = view_.layout.channel;
  if (!found.image.axes.empty()) view_.layout.unit = found.image.axes[view_.space[0]].unit;

  fill_.resize(bytesPerVoxel(array.type));
  visitVoxelType(array.type, [&](auto tag) {
    tag = static_cast<decltype(tag)>(array.fill_value);
    std::memcpy(fill_.data(), &tag, sizeof tag);
  });
  header_bytes_ = found.header_bytes;
  identity_ = identityOf(found.array_folder);
  for (const std::string& identity : found.identities) identity_ += fmt::format("|{}", identity);
  if (view_.channel) identity_ += fmt::format("|channel {}", channel_);

  places_ = found.header_paths;
  places_.push_back(found.array_folder.name());
  places_.push_back(folder.name());

  files_ = std::make_unique<ZarrChunkFiles>(found.array_folder, std::move(array), header.text);
  // With checksums a changed chunk is an Error when it is read.
  identity_ +=
      fmt::format("|{:016x}", files_->hasChecksums() ? files_->digestOfChecksums()
                                                     : files_->stampChecksum(kSampledChunks));
  array_number_ = cache_->addArray(
      files_->array().chunkBytes(),
      [this](int64_t chunk, ChunkMemory& memory) { return decode(chunk, memory); });
  if (found.is_image) openLevels(folder, found);
}

void ZarrSource::openLevels(const StorePlace& folder, const FoundZarr& found) {
  VolumeLayout& layout = view_.layout;
  const LevelClaim finest = claimOf(view_, found.image, 0);
  if (isZarr(folder.at(found.image.spreads).at(found.image.levels[0])))
    spreads_ = openSpreads(folder, found, 0, layout);
  std::vector<size_t> datasets;  // of level_sources_
  for (size_t i = 1; i < found.image.levels.size(); ++i) {
    std::string fault;
    try {
      std::unique_ptr<ZarrSource> source =
          openPart(folder, datasetOf(found, folder.at(found.image.levels[i]), i));
      fault = faultAmong(layout, source->view_.layout);
      if (fault.empty()) fault = faultOfLevel(finest, claimOf(source->view_, found.image, i));
      if (fault.empty()) {
        spread_sources_.push_back(openSpreads(folder, found, i, source->view_.layout));
        level_sources_.push_back(std::move(source));
        datasets.push_back(i);
      }
    } catch (const Error& error) {
      fault = error.what();
    }
    if (!fault.empty())
      layout.notes.push_back(fmt::format("{}: level {} is left out: {}", folder.name(), i, fault));
  }
  placeLevels(folder.name(), found, datasets);
  layout.levels = 1 + static_cast<int64_t>(levels_above_.size());
}

std::unique_ptr<ZarrSource> ZarrSource::openPart(const StorePlace& folder, FoundZarr found) {
  const ChannelWish channel = view_.channel ? ChannelWish(channel_) : ChannelWish();
  return std::unique_ptr<ZarrSource>(
      new ZarrSource(folder, std::move(found), channel, cache_, Part::kLevel));
}

std::unique_ptr<ZarrSource> ZarrSource::openSpreads(const StorePlace& folder,
                                                    const FoundZarr& found, size_t dataset,
                                                    const VolumeLayout& level) {
  if (found.image.spreads.empty()) return nullptr;
  std::string fault;
  try {
    const StorePlace array = folder.at(found.image.spreads).at(found.image.levels[dataset]);
    std::unique_ptr<ZarrSource> source = openPart(folder, datasetOf(found, array, dataset));
    fault = faultOfSpreads(level, source->view_.layout);
    if (fault.empty()) return source;
  } catch (const Error& error) {
    fault = error.what();
  }
  view_.layout.notes.push_back(
      fmt::format("{}: the spread of level {} is left out: {}", folder.name(), dataset, fault));
  return nullptr;
}

std::vector<ZarrSource*> ZarrSource::sourcesAbove() const {
  std::vector<ZarrSource*> sources;
  for (const auto* list : {&level_sources_, &spread_sources_})
    for (const auto& source : *list)
      if (source != nullptr) sources.push_back(source.get());
  if (spreads_ != nullptr) sources.push_back(spreads_.get());
  return sources;
}

void ZarrSource::placeLevels(const std::string& path, const FoundZarr& found,
                             const std::vector<size_t>& datasets) {
  const LevelClaim finest = claimOf(view_, found.image, 0);
  bool is_translated = found.image.places[0].is_translated;
  for (size_t i = 0; i < datasets.size(); ++i) {
    const LevelClaim claim = claimOf(level_sources_[i]->view_, found.image, datasets[i]);
    LevelPlacement place{levelFactor(finest, claim), {}};
    is_translated = is_translated || found.image.places[datasets[i]].is_translated;
    if (claim.translation && finest.translation)
      place.offset = (*claim.translation - *finest.translation) / *finest.scale;
    levels_above_.push_back({level_sources_[i].get(), place, spread_sources_[i].get()});
  }
  std::stable_sort(levels_above_.begin(), levels_above_.end(),
                   [](const CoarserLevel& a, const CoarserLevel& b) {
                     const Vec3d f = a.placement.scale, g = b.placement.scale;
                     return f.x * f.y * f.z < g.x * g.y * g.z;
                   });
  if (levels_above_.empty() || is_translated) return;

  // The two coarsest with a few voxels a side: the fewest bytes that show it.
  constexpr int64_t kLeastSide = 8;
  size_t at = levels_above_.size() - 1;
  const auto leastSide = [&](size_t i) {
    const Vec3i d = levels_above_[i].source->layout().dims;
    return std::min({d.x, d.y, d.z});
  };
  while (at > 0 && leastSide(at) < kLeastSide) --at;
  VolumeSource& fine = at == 0 ? static_cast<VolumeSource&>(*this) : *levels_above_[at - 1].source;
  const Vec3d finer = at == 0 ? Vec3d{1, 1, 1} : levels_above_[at - 1].placement.scale;
  const auto origin =
      originOf(fine, *levels_above_[at].source, levels_above_[at].placement.scale / finer);
  for (CoarserLevel& level : levels_above_)
    level.placement.offset = offsetOf(origin.value_or(VoxelOrigin::kCorner), level.placement.scale);
  view_.layout.notes.push_back(fmt::format(
      "{}: its levels have no translation; comparing levels {} and {} {}", path, at, at + 1,
      !origin ? "does not tell where their voxels lie; sluice assumes a common corner"
      : *origin == VoxelOrigin::kCorner ? "shows voxels that begin at a common corner"
                                        : "shows first voxels with a common centre"));
}

uint64_t ZarrSource::storedBytesRead() const {
  uint64_t bytes = header_bytes_ + files_->storedBytesRead();
  for (const ZarrSource* source : sourcesAbove()) bytes += source->storedBytesRead();
  return bytes;
}

uint64_t ZarrSource::heldBytesAThread() const {
  const ZarrArray& array = files_->array();
  uint64_t bytes = 3 * array.chunkBytes() + (array.shards ? 2 * array.shardIndexBytes() : 0);
  for (const ZarrSource* source : sourcesAbove())
    bytes = std::max(bytes, source->heldBytesAThread());
  return bytes;
}

void ZarrSource::holdAtMost(uint64_t bytes) {
  if (part_ == Part::kLevel) return;
  std::vector<ZarrShardIndices*> indices{files_->shardIndices()};
  for (const ZarrSource* source : sourcesAbove()) indices.push_back(source->files_->shardIndices());
  std::erase(indices, nullptr);
  const uint64_t each = indices.empty() ? 0 : bytes / 8 / indices.size();
  for (ZarrShardIndices* of_array : indices) of_array->setBudget(each);
  cache_->setBudget(bytes - each * indices.size());
}

std::vector<std::string> ZarrSource::files() {
  return places_;
}

Vec3i ZarrSource::voxelsOf(std::span<const int64_t> parts) const {
  return {parts[view_.space[0]], parts[view_.space[1]], parts[view_.space[2]]};
}

Vec3i ZarrSource::chunkVoxels() const {
  return voxelsOf(files_->array().chunks);
}

// The part of the array, a chunk or a file, that holds a voxel.
std::vector<int64_t> ZarrSource::indexAt(std::span<const int64_t> parts, int64_t time,
                                         Vec3i at) const {
  std::vector<int64_t> index(parts.size(), 0);
  for (int a = 0; a < 3; ++a) {
    const size_t axis = view_.space[static_cast<size_t>(a)];
    index[axis] = at[a] / parts[axis];
  }
  if (view_.time) index[*view_.time] = time / parts[*view_.time];
  if (view_.channel) index[*view_.channel] = channel_ / parts[*view_.channel];
  return index;
}

ZarrChunkCache::Chunk ZarrSource::filledChunk(ChunkMemory& memory) const {
  const ZarrArray& array = files_->array();
  auto chunk = std::make_shared<CountedBytes>(array.chunkBytes(), memory);
  fillRow(fill_, chunk->span().data(), static_cast<int64_t>(array.chunkBytes() / fill_.size()));
  return chunk;
}

ZarrChunkCache::Chunk ZarrSource::decode(int64_t chunk, ChunkMemory& memory) {
  const ZarrArray& array = files_->array();
  std::shared_ptr<CountedBytes> decoded;
  std::unique_ptr<CountedBytes> stored;
  const std::optional<uint64_t> stored_bytes = files_->read(chunk, [&](uint64_t bytes) {
    if (array.codec == ZarrCodec::kNone) {
      decoded = std::make_shared<CountedBytes>(bytes, memory);
      return decoded->span();
    }
    // For chunks of up to kSmallChunkBytes, the buffer has the size of a decoded chunk, so that it
    // can be reused for any of them.
    stored = std::make_unique<CountedBytes>(
        std::max(bytes, std::min(array.chunkBytes(), kSmallChunkBytes)), memory);
    return stored->span().first(bytes);
  });
  if (!stored_bytes) return filledChunk(memory);
  if (stored) {
    const auto file = std::as_const(*stored).span().first(*stored_bytes);
    const std::string path = files_->path(chunk);
    checkStored(array.codec, file, array.chunkBytes(), path);
    decoded = std::make_shared<CountedBytes>(array.chunkBytes(), memory);
    decodeChunk(array.codec, file, decoded->span(), path);
  }
  if (array.byte_order != std::endian::native)
    swapBytes(decoded->span().first(array.chunkBytes()), bytesPerVoxel(array.type));
  return decoded;
}

// `part` of `box` out of the one chunk that holds it.
void ZarrSource::copyChunk(std::span<const std::byte> chunk, int64_t time, const Box3& part,
                           const Box3& box, std::span<std::byte> out) const {
  const ZarrArray& array = files_->array();
  const std::vector<int64_t> strides = stridesInChunk(array);
  const auto voxel = static_cast<int64_t>(bytesPerVoxel(array.type));
  int64_t base = 0;
  if (view_.time) base += time % array.chunks[*view_.time] * strides[*view_.time];
  if (view_.channel) base += channel_ % array.chunks[*view_.channel] * strides[*view_.channel];
  Vec3i stride;
  for (int a = 0; a < 3; ++a) {
    const size_t axis = view_.space[static_cast<size_t>(a)];
    stride[a] = strides[axis];
    base += part.lo[a] % array.chunks[axis] * strides[axis];
  }
  const Vec3i size = part.size(), whole = box.size(), at = part.lo - box.lo;
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y) {
      const int64_t from = base + z * stride.z + y * stride.y;
      const int64_t to = ((at.z + z) * whole.y + at.y + y) * whole.x + at.x;
      copyRow(chunk.data() + from * voxel, stride.x * voxel, out.data() + to * voxel, size.x,
              static_cast<size_t>(voxel));
    }
}

void ZarrSource::readRegion(int64_t time, const Box3& box, std::span<std::byte> out) {
  const VolumeLayout& layout = view_.layout;
  const auto voxel = static_cast<int64_t>(fill_.size());
  SLUICE_CHECK(!box.empty() && boxOf(layout.dims).contains(box));
  SLUICE_CHECK(time >= 0 && time < layout.time_steps);
  SLUICE_CHECK_EQ(static_cast<int64_t>(out.size()), box.count() * voxel);
  const Vec3i step = chunkVoxels();
  const Vec3i first = box.lo / step * step;
  for (int64_t z = first.z; z < box.hi.z; z += step.z)
    for (int64_t y = first.y; y < box.hi.y; y += step.y)
      for (int64_t x = first.x; x < box.hi.x; x += step.x) {
        const Vec3i corner{x, y, z};
        const Box3 part = intersect(box, {corner, corner + step});
        const ZarrArray& array = files_->array();
        const int64_t number = array.chunkNumber(indexAt(array.chunks, time, corner));
        if (files_->exists(number)) {
          copyChunk(cache_->get({array_number_, number})->span(), time, part, box, out);
          continue;
        }
        const Vec3i at = part.lo - box.lo;
        for (int64_t pz = at.z; pz < at.z + part.size().z; ++pz)
          for (int64_t py = at.y; py < at.y + part.size().y; ++py)
            fillRow(fill_, out.data() + ((pz * box.size().y + py) * box.size().x + at.x) * voxel,
                    part.size().x);
      }
}

std::optional<Occupancy> ZarrSource::occupancy(int64_t time) {
  if (!files_->areKnown()) return std::nullopt;
  const ZarrArray& array = files_->array();
  const Vec3i step = voxelsOf(array.files);
  const Vec3i dims = view_.layout.dims;
  const std::vector<int64_t> wanted = indexAt(array.files, time, {0, 0, 0});
  Occupancy occupancy;
  occupancy.background = array.fill_value;
  int64_t present = 0;
  for (const int64_t number : files_->existing()) {
    const std::vector<int64_t> index = array.fileIndex(number);
    if ((view_.time && index[*view_.time] != wanted[*view_.time]) ||
        (view_.channel && index[*view_.channel] != wanted[*view_.channel]))
      continue;
    ++present;
    const Vec3i lo =
        step * Vec3i{index[view_.space[0]], index[view_.space[1]], index[view_.space[2]]};
    const Box3 box = intersect({lo, lo + step}, boxOf(dims));
    // Files that follow one another along x, as the numbers mostly do, are one box.
    Box3* last = occupancy.boxes.empty() ? nullptr : &occupancy.boxes.back();
    const bool goes_on = last != nullptr && last->hi.x == box.lo.x && last->lo.y == box.lo.y &&
                         last->lo.z == box.lo.z;
    if (goes_on)
      last->hi.x = box.hi.x;
    else
      occupancy.boxes.push_back(box);
  }
  const Vec3i grid{ceilDiv(dims.x, step.x), ceilDiv(dims.y, step.y), ceilDiv(dims.z, step.z)};
  if (present == volume(grid)) return std::nullopt;
  return occupancy;
}

}  // namespace sluice
