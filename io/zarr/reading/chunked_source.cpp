#include "io/zarr/reading/chunked_source.h"

#include <algorithm>
#include <cstring>
#include <deque>
#include <map>
#include <utility>

#include "io/files/copy_row.h"
#include "io/files/missing_values.h"
#include "io/zarr/reading/zarr_rows.h"
#include "src/base/error.h"
#include "src/base/sources/region_check.h"

namespace sluice {

namespace {

// Chunks that a thread leaves to others before it waits for the first of them.
constexpr size_t kMostLate = 4;

}  // namespace

ChunkedSource::ChunkedSource(const ChunkedVolume& volume, const ChunkedOptions& options)
    : ChunkedSource(volume, volume.open(0), 0, options.channel,
                    std::make_shared<ZarrChunkCache>(options.chunk_cache_bytes), Part::kImage) {}

ChunkedSource::~ChunkedSource() = default;

ChunkedSource::ChunkedSource(const ChunkedVolume& volume, OpenedArray opened, size_t level,
                             const ChannelWish& channel, std::shared_ptr<ZarrChunkCache> cache,
                             Part part)
    : array_(std::move(opened.array)), cache_(std::move(cache)), part_(part) {
  const ZarrArray& array = array_->array();
  ZarrImage image = volume.image;
  if (part_ == Part::kLevel) {
    image.scale = image.places[level].scale;
    image.translation = image.places[level].translation;
  }
  view_ = viewZarr(array, image, channel.given(), volume.said_by);
  view_.layout.name = volume.title + (image.level_set ? " (level set)" : "");
  view_.layout.path = volume.name;
  if (channel.given() && !view_.channel)
    failRequest("{}: --channel {}: the volume has no channels; leave it out", volume.name,
                channel.text());
  channel_names_ = image.channels;
  channel_looks_ = image.looks;
  view_.layout.notes = array.notes;
  if (part_ == Part::kImage) {
    for (const std::vector<std::string>& notes : {volume.notes, view_.notes})
      view_.layout.notes.insert(view_.layout.notes.end(), notes.begin(), notes.end());
    if (const std::string note = missingValuesNote(image.missing, view_.layout); !note.empty())
      view_.layout.notes.push_back(volume.name + ": " + note);
    if (const std::string note =
            invalidValuesNote(image.valid_least, image.valid_greatest, view_.layout);
        !note.empty())
      view_.layout.notes.push_back(volume.name + ": " + note);
    for (const std::string& note : image.notes)
      view_.layout.notes.push_back(fmt::format("{}: {}", volume.name, note));
    const auto described = static_cast<int64_t>(image.channels.size());
    if (described > view_.layout.channels && view_.channel)
      view_.layout.notes.push_back(fmt::format("{}: omero describes {} channels of {}", volume.name,
                                               described, view_.layout.channels));
  }
  // A level without the channel has other channels than the image: openLevels() leaves it out.
  if (part_ == Part::kImage || channel.number.value_or(0) < view_.layout.channels)
    chooseChannel(volume.name, channel, channel_names_, view_.layout);
  channel_ = view_.layout.channel;

  fill_.resize(bytesPerVoxel(array.type));
  visitVoxelType(array.type, [&](auto tag) {
    tag = static_cast<decltype(tag)>(array.fill_value);
    std::memcpy(fill_.data(), &tag, sizeof tag);
  });
  blanked_ = blankedNumbers(array.type, image.missing);
  blank(array.type, blanked_, fill_);
  header_bytes_ = opened.header_bytes;
  identity_ = opened.identity;
  places_ = opened.places;
  if (part_ == Part::kImage) {
    header_bytes_ += volume.header_bytes;
    for (const std::string& identity : volume.identities) identity_ += "|" + identity;
    places_.insert(places_.begin(), volume.places.begin(), volume.places.end());
    places_.push_back(volume.name);
  }
  if (view_.channel) identity_ += fmt::format("|channel {}", channel_);
  if (!blanked_.empty()) identity_ += fmt::format("|without {}", fmt::join(blanked_, ", "));
  identity_ += "|" + array_->stamp();
  array_number_ = cache_->addArray(array.chunkBytes(), [this](int64_t chunk, ChunkMemory& memory) {
    return load(chunk, memory);
  });
  if (part_ == Part::kImage && volume.is_image) openLevels(volume);
}

uint64_t ChunkedSource::storedBytesRead() const {
  uint64_t bytes = header_bytes_ + array_->storedBytesRead();
  for (const ChunkedSource* source : sourcesAbove()) bytes += source->storedBytesRead();
  return bytes;
}

uint64_t ChunkedSource::heldBytesAThread() const {
  uint64_t bytes = 3 * array_->array().chunkBytes() + 2 * array_->indexBytes();
  for (const ChunkedSource* source : sourcesAbove())
    bytes = std::max(bytes, source->heldBytesAThread());
  return bytes;
}

template <class Visit>
void ChunkedSource::eachChunk(int64_t time, const Box3& box, const Visit& visit) const {
  const Vec3i step = chunkVoxels(), first = box.lo / step * step;
  const ZarrArray& array = array_->array();
  for (int64_t z = first.z; z < box.hi.z; z += step.z)
    for (int64_t y = first.y; y < box.hi.y; y += step.y)
      for (int64_t x = first.x; x < box.hi.x; x += step.x)
        visit(Vec3i{x, y, z}, array.chunkNumber(indexAt(array.chunks, time, {x, y, z})));
}

std::optional<StoredReads> ChunkedSource::storedReads(int64_t time, std::span<const LevelBox> boxes,
                                                      uint64_t held_bytes) {
  std::map<const VolumeSource*, ChunkedSource*> sources{{nullptr, this}};
  for (ChunkedSource* source : sourcesAbove()) sources.emplace(source, source);
  std::map<ChunkedSource*, std::vector<Box3>> needed;
  for (const LevelBox& box : boxes) {
    const auto found = sources.find(box.level);
    if (found != sources.end() && !box.box.empty()) needed[found->second].push_back(box.box);
  }
  StoredReads reads;
  for (auto& [source, of_source] : needed) reads += source->storedReads(time, of_source);
  // Boxes are read by several threads, so that no order of them is certain.
  if (reads.decoded_bytes <= held_bytes) reads.decodes = reads.chunks;
  return reads;
}

StoredReads ChunkedSource::storedReads(int64_t time, std::vector<Box3>& boxes) {
  std::sort(boxes.begin(), boxes.end(),
            [](const Box3& a, const Box3& b) { return a.lo.z < b.lo.z; });
  const int64_t depth = voxelsOf(array_->array().files).z;
  StoredReads reads;
  std::vector<Box3> active;
  std::vector<int64_t> numbers;
  // One layer of files after the other, so that no list has all chunks of a large level. No file
  // lies in two layers.
  for (size_t next = 0; next < boxes.size() || !active.empty();) {
    int64_t from = active.empty() ? boxes[next].lo.z : INT64_MAX;
    for (const Box3& box : active) from = std::min(from, box.lo.z);
    const int64_t end = (from / depth + 1) * depth;
    for (; next < boxes.size() && boxes[next].lo.z < end; ++next) active.push_back(boxes[next]);
    numbers.clear();
    for (Box3& box : active) {
      Box3 inside = box;
      inside.hi.z = std::min(inside.hi.z, end);
      eachChunk(time, inside, [&](Vec3i /*corner*/, int64_t number) { numbers.push_back(number); });
      box.lo.z = inside.hi.z;
    }
    std::erase_if(active, [](const Box3& box) { return box.empty(); });
    const auto uses = static_cast<int64_t>(numbers.size());
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    StoredReads layer = array_->storedReads(numbers);
    layer.decoded_bytes = numbers.size() * array_->array().chunkBytes();
    layer.decodes = uses;
    reads += layer;
  }
  return reads;
}

void ChunkedSource::holdAtMost(uint64_t bytes) {
  // The levels share the image's cache.
  if (part_ == Part::kLevel) return;
  std::vector<ChunkedArray*> indexed{array_.get()};
  for (const ChunkedSource* source : sourcesAbove()) indexed.push_back(source->array_.get());
  std::erase_if(indexed, [](const ChunkedArray* array) { return array->indexBytes() == 0; });
  // An eighth for the indices of shards, shared by the arrays that have some.
  const uint64_t each = indexed.empty() ? 0 : bytes / 8 / indexed.size();
  for (ChunkedArray* array : indexed) array->holdIndices(each);
  cache_->setBudget(bytes - each * indexed.size());
}

PassReads ChunkedSource::passReads() const {
  const ZarrArray& array = array_->array();
  if (array.codec != ZarrCodec::kNone || distantReads() > 0) return {};
  // A layer of blocks begins in the last chunks of the layer before. Other axes, and blocks that
  // are thicker than usual, only mean that some chunks are read twice.
  constexpr int64_t kPlanes = 2 * 64;
  const Vec3i step = chunkVoxels(), dims = view_.layout.dims;
  const int64_t layers = std::min(ceilDiv(kPlanes, step.z) + 1, ceilDiv(dims.z, step.z));
  const auto chunks = static_cast<double>(ceilDiv(dims.x, step.x)) *
                      static_cast<double>(ceilDiv(dims.y, step.y)) * static_cast<double>(layers);
  constexpr double kMost = 0x1p62;
  const double bytes = std::min(chunks * static_cast<double>(array.chunkBytes()), kMost);
  // On a disk that reads 0.9 GB/s, two cores: 1 thread each reads cold chunks of 256 KiB at 0.70 of
  // the speed of one large file, 2 at 0.84, 4 at 0.92.
  constexpr int kThreadsEach = 4;
  return {static_cast<uint64_t>(bytes), kThreadsEach};
}

std::vector<std::string> ChunkedSource::files() {
  return places_;
}

Vec3i ChunkedSource::voxelsOf(std::span<const int64_t> parts) const {
  return {parts[view_.space[0]], parts[view_.space[1]], parts[view_.space[2]]};
}

Vec3i ChunkedSource::chunkVoxels() const {
  return voxelsOf(array_->array().chunks);
}

// The part of the array, a chunk or a file, that holds a voxel.
std::vector<int64_t> ChunkedSource::indexAt(std::span<const int64_t> parts, int64_t time,
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

ZarrChunkCache::Chunk ChunkedSource::load(int64_t chunk, ChunkMemory& memory) {
  // A chunk without a file is all fill value.
  if (std::shared_ptr<CountedBytes> loaded = array_->load(chunk, memory)) {
    blank(array_->array().type, blanked_, loaded->span());
    return loaded;
  }
  const uint64_t bytes = array_->array().chunkBytes();
  auto filled = std::make_shared<CountedBytes>(bytes, memory);
  fillRow(fill_, filled->span().data(), static_cast<int64_t>(bytes / fill_.size()));
  return filled;
}

// `part` of `box` out of the one chunk that holds it.
void ChunkedSource::copyChunk(std::span<const std::byte> chunk, int64_t time, const Box3& part,
                              const Box3& box, std::span<std::byte> out) const {
  const ZarrArray& array = array_->array();
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

void ChunkedSource::readRegion(int64_t time, const Box3& box, std::span<std::byte> out) {
  const RegionRead region{box, out};
  readRegions(time, std::span(&region, 1));
}

// The regions that a chunk has voxels of, and the chunk.
struct ChunkedSource::Use {
  int64_t number = 0;
  Vec3i corner;
  const RegionRead* region = nullptr;
};

void ChunkedSource::copyUses(std::span<const Use> uses, int64_t time,
                             std::span<const std::byte> chunk) const {
  for (const Use& use : uses) {
    const Box3& box = use.region->box;
    copyChunk(chunk, time, intersect(box, {use.corner, use.corner + chunkVoxels()}), box,
              use.region->out);
  }
}

void ChunkedSource::fillUses(std::span<const Use> uses) const {
  const auto voxel = static_cast<int64_t>(fill_.size());
  for (const Use& use : uses) {
    const Box3& box = use.region->box;
    const Box3 part = intersect(box, {use.corner, use.corner + chunkVoxels()});
    const Vec3i at = part.lo - box.lo;
    for (int64_t z = at.z; z < at.z + part.size().z; ++z)
      for (int64_t y = at.y; y < at.y + part.size().y; ++y)
        fillRow(fill_,
                use.region->out.data() + ((z * box.size().y + y) * box.size().x + at.x) * voxel,
                part.size().x);
  }
}

// A chunk that several regions share, such as a slab across the volume, is decoded once for all of
// them, even if the memory holds no more than that chunk.
void ChunkedSource::readRegions(int64_t time, std::span<const RegionRead> regions) {
  // Neighbouring blocks share chunks. A thread that waited for each that another one is decoding
  // would follow that one through all of them, and only one chunk would be read at a time. It comes
  // back soon, before they leave the memory.
  std::deque<std::vector<Use>> late;
  const auto copyLate = [&](IfLoading if_loading) {
    const std::vector<Use>& uses = late.front();
    const auto chunk = cache_->get({array_number_, uses.front().number}, if_loading);
    if (chunk == nullptr) return false;
    copyUses(uses, time, chunk->span());
    late.pop_front();
    return true;
  };
  const auto read = [&](std::span<const Use> uses) {
    const int64_t number = uses.front().number;
    if (!array_->exists(number)) {
      fillUses(uses);
      return;
    }
    if (const auto chunk = cache_->get({array_number_, number}, IfLoading::kLeave))
      copyUses(uses, time, chunk->span());
    else
      late.emplace_back(uses.begin(), uses.end());
    while (late.size() > kMostLate) copyLate(IfLoading::kWait);
    while (!late.empty() && copyLate(IfLoading::kLeave)) {
    }
  };
  int64_t first = INT64_MAX, end = 0;
  for (const RegionRead& region : regions) {
    checkRegion(view_.layout, time, region.box, region.out);
    first = std::min(first, region.box.lo.z);
    end = std::max(end, region.box.hi.z);
  }
  const int64_t depth = chunkVoxels().z;
  std::vector<Use> uses;
  // One layer of chunks after the other, so that the list of a box of tiny chunks stays short.
  for (int64_t z = first / depth * depth; z < end; z += depth) {
    uses.clear();
    for (const RegionRead& region : regions) {
      Box3 layer = region.box;
      layer.lo.z = std::max(layer.lo.z, z);
      layer.hi.z = std::min(layer.hi.z, z + depth);
      if (layer.empty()) continue;
      eachChunk(time, layer, [&](Vec3i corner, int64_t number) {
        uses.push_back({number, corner, &region});
      });
    }
    std::ranges::stable_sort(uses, {}, &Use::number);
    for (size_t from = 0, to = 0; from < uses.size(); from = to) {
      while (to < uses.size() && uses[to].number == uses[from].number) ++to;
      read(std::span(uses).subspan(from, to - from));
    }
  }
  while (!late.empty()) copyLate(IfLoading::kWait);
}

std::optional<Occupancy> ChunkedSource::occupancy(int64_t time) {
  if (!array_->areKnown()) return std::nullopt;
  const ZarrArray& array = array_->array();
  const Vec3i step = voxelsOf(array.files);
  const Vec3i dims = view_.layout.dims;
  const std::vector<int64_t> wanted = indexAt(array.files, time, {0, 0, 0});
  Occupancy occupancy;
  visitVoxelType(array.type, [&](auto tag) {
    std::memcpy(&tag, fill_.data(), sizeof tag);
    occupancy.background = static_cast<double>(tag);
  });
  int64_t present = 0;
  for (const int64_t number : array_->existing()) {
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
  // Nothing is known to be empty.
  if (present == volume(grid)) return std::nullopt;
  return occupancy;
}

}  // namespace sluice
