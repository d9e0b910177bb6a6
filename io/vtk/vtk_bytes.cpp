#include "io/vtk/vtk_bytes.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "io/files/swap_bytes.h"
#include "io/zarr/reading/zarr_chunk_cache.h"
#include "io/zarr/reading/zarr_codec.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// Three bytes are four characters.
constexpr uint64_t kGroupBytes = 3, kGroupChars = 4;

uint64_t base64Chars(uint64_t bytes) {
  return ceilDiv(static_cast<int64_t>(bytes), static_cast<int64_t>(kGroupBytes)) * kGroupChars;
}

constexpr std::array<int16_t, 256> kBase64Values = [] {
  std::array<int16_t, 256> values{};
  for (int16_t& value : values) value = -1;
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (int16_t i = 0; i < 64; ++i) values[static_cast<unsigned char>(digits[i])] = i;
  return values;
}();

// The bytes that a stretch of base64 stands for.
class Base64Bytes final : public ByteStore {
 public:
  Base64Bytes(std::shared_ptr<File> file, uint64_t at) : file_(std::move(file)), at_(at) {}

  void read(uint64_t offset, std::span<const iovec> parts) override {
    for (const iovec& part : parts) {
      readPart(offset, {static_cast<std::byte*>(part.iov_base), part.iov_len});
      offset += part.iov_len;
    }
  }
  uint64_t storedBytesRead() const override { return file_->storedBytesRead(); }
  std::vector<std::string> paths() const override { return file_->paths(); }

 private:
  void readPart(uint64_t offset, std::span<std::byte> out) {
    constexpr size_t kGroups = 4096;
    std::array<std::byte, kGroups * kGroupChars> text;
    std::array<std::byte, kGroups * kGroupBytes> bytes;
    while (!out.empty()) {
      const uint64_t group = offset / kGroupBytes;
      const size_t inside = offset % kGroupBytes;
      const size_t groups =
          std::min<size_t>(kGroups, base64Chars(inside + out.size()) / kGroupChars);
      const uint64_t from = at_ + group * kGroupChars;
      file_->readAt(from, std::span(text).first(groups * kGroupChars));
      const size_t taken = std::min(out.size(), groups * kGroupBytes - inside);
      decode(std::span(text).first(groups * kGroupChars), bytes, inside + taken, from);
      std::memcpy(out.data(), bytes.data() + inside, taken);
      out = out.subspan(taken);
      offset += taken;
    }
  }

  // `wanted`: bytes that have to be there; those behind them may be padding.
  void decode(std::span<const std::byte> text, std::span<std::byte> bytes, size_t wanted,
              uint64_t from) const {
    for (size_t group = 0; group * kGroupBytes < wanted; ++group) {
      uint32_t value = 0;
      // A group of n bytes has n + 1 characters; '=' pads the rest.
      const size_t needed = std::min(wanted - group * kGroupBytes, size_t{kGroupBytes}) + 1;
      for (size_t i = 0; i < kGroupChars; ++i) {
        const size_t at = group * kGroupChars + i;
        const int digit = kBase64Values[static_cast<unsigned char>(text[at])];
        if (digit < 0 && i < needed)
          fail("{}: expected base64 without a gap at {}, found another character or its end",
               file_->path(), from + at);
        value = value << 6 | static_cast<uint32_t>(std::max(digit, 0));
      }
      for (size_t i = 0; i < kGroupBytes; ++i)
        bytes[group * kGroupBytes + i] = static_cast<std::byte>(value >> (16 - 8 * i));
    }
  }

  const std::shared_ptr<File> file_;
  const uint64_t at_;
};

uint64_t readNumber(ByteStore& store, uint64_t offset, const VtkImage& image) {
  std::array<std::byte, 8> bytes{};
  const std::span<std::byte> number = std::span(bytes).first(image.header_bytes);
  const iovec part{number.data(), number.size()};
  store.read(offset, std::span(&part, 1));
  if (image.byte_order != std::endian::native) swapBytes(number, number.size());
  uint64_t value = 0;
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

ZarrCodec codecOfBlocks(VtkCodec codec) {
  return codec == VtkCodec::kZlib  ? ZarrCodec::kDeflate
         : codec == VtkCodec::kLz4 ? ZarrCodec::kLz4
                                   : ZarrCodec::kXz;
}

// Compressed blocks of one length, except perhaps the last. Their sizes stand in front of them and
// are read a stretch at a time, so that a file of many blocks takes no memory for them.
class CompressedBlocks final : public ByteStore {
 public:
  struct Layout {
    std::shared_ptr<ByteStore> sizes, data;
    uint64_t sizes_at = 0, data_at = 0;
    uint64_t blocks = 0, block_bytes = 0, bytes = 0;
  };

  CompressedBlocks(Layout layout, const VtkImage& image, std::string path)
      : layout_(std::move(layout)), path_(std::move(path)), cache_(kCacheBytes) {
    image_.byte_order = image.byte_order;
    image_.header_bytes = image.header_bytes;
    image_.codec = image.codec;
    // Sizes are stored alone, so that the place of each block is the sum of those before it.
    uint64_t at = layout_.data_at;
    std::vector<std::byte> sizes;
    for (uint64_t block = 0; block < layout_.blocks; ++block) {
      if (block % kStretch == 0) {
        sizes = stretchFrom(block);
        starts_.push_back(at);
      }
      at += sizeIn(sizes, block % kStretch);
    }
    cache_.addArray(layout_.block_bytes,
                    [this](int64_t block, ChunkMemory& memory) { return decode(block, memory); });
  }

  void read(uint64_t offset, std::span<const iovec> parts) override {
    for (const iovec& part : parts) {
      std::span<std::byte> out(static_cast<std::byte*>(part.iov_base), part.iov_len);
      while (!out.empty()) {
        const uint64_t block = offset / layout_.block_bytes, inside = offset % layout_.block_bytes;
        const ZarrChunkCache::Chunk decoded = cache_.get({0, static_cast<int64_t>(block)});
        const auto from = decoded->span().subspan(inside);
        const size_t taken = std::min(from.size(), out.size());
        std::memcpy(out.data(), from.data(), taken);
        out = out.subspan(taken);
        offset += taken;
      }
    }
  }
  uint64_t unitBytes() const override { return layout_.block_bytes; }
  uint64_t heldBytesAThread() const override { return 3 * layout_.block_bytes; }
  void holdAtMost(uint64_t bytes) override { cache_.setBudget(bytes); }
  uint64_t storedBytesRead() const override { return layout_.data->storedBytesRead(); }
  std::vector<std::string> paths() const override { return layout_.data->paths(); }

 private:
  static constexpr uint64_t kCacheBytes = uint64_t{32} << 20;
  static constexpr uint64_t kStretch = 512;  // blocks

  // The stored sizes of the blocks of a stretch.
  std::vector<std::byte> stretchFrom(uint64_t block) const {
    const uint64_t count = std::min(kStretch, layout_.blocks - block);
    std::vector<std::byte> sizes(count * image_.header_bytes);
    const iovec part{sizes.data(), sizes.size()};
    layout_.sizes->read(layout_.sizes_at + block * image_.header_bytes, std::span(&part, 1));
    if (image_.byte_order != std::endian::native) swapBytes(sizes, image_.header_bytes);
    return sizes;
  }
  uint64_t sizeIn(std::span<const std::byte> sizes, uint64_t i) const {
    uint64_t size = 0;
    std::memcpy(&size, sizes.data() + i * image_.header_bytes, image_.header_bytes);
    // The size comes from the file, so that it is checked before memory is taken for it.
    checkStoredSize(codecOfBlocks(image_.codec), size, layout_.block_bytes, path_);
    return size;
  }

  ZarrChunkCache::Chunk decode(int64_t number, ChunkMemory& memory) {
    const auto block = static_cast<uint64_t>(number);
    const std::vector<std::byte> sizes = stretchFrom(block / kStretch * kStretch);
    uint64_t at = starts_[block / kStretch];
    for (uint64_t i = 0; i < block % kStretch; ++i) at += sizeIn(sizes, i);
    CountedBytes stored(sizeIn(sizes, block % kStretch), memory);
    const iovec part{stored.span().data(), stored.span().size()};
    layout_.data->read(at, std::span(&part, 1));
    const uint64_t bytes =
        std::min(layout_.block_bytes, layout_.bytes - block * layout_.block_bytes);
    const ZarrCodec codec = codecOfBlocks(image_.codec);
    const std::string path = fmt::format("{}: block {}", path_, block);
    checkStored(codec, stored.span(), bytes, path);
    auto decoded = std::make_shared<CountedBytes>(bytes, memory);
    decodeChunk(codec, stored.span(), decoded->span(), path);
    return decoded;
  }

  const Layout layout_;
  const std::string path_;
  VtkImage image_;                // the form of its numbers
  std::vector<uint64_t> starts_;  // of each stretch, in `data`
  ZarrChunkCache cache_;
};

}  // namespace

VtkBytes openVtkBytes(const std::shared_ptr<File>& file, const VtkImage& image,
                      const VtkArray& array, uint64_t bytes) {
  const std::string path = fmt::format("{}: array '{}'", file->path(), array.name);
  const bool is_text = array.form == VtkForm::kBase64;
  const auto requireRoom = [&](uint64_t offset, uint64_t wanted) {
    const uint64_t chars = is_text ? base64Chars(offset + wanted) : offset + wanted;
    if (array.offset > file->sizeBytes() || chars > file->sizeBytes() - array.offset)
      fail("{}: expected {} bytes from {} on, found {} up to the end of the file; it was cut short",
           path, chars, array.offset,
           file->sizeBytes() - std::min(file->sizeBytes(), array.offset));
  };
  VtkBytes found{file, array.offset};
  if (is_text) found = {std::make_shared<Base64Bytes>(file, array.offset), 0};
  if (!image.has_block_headers) {
    requireRoom(0, bytes);
    return found;
  }
  requireRoom(0, image.header_bytes);
  const uint64_t first = readNumber(*found.store, found.offset, image);
  if (image.codec == VtkCodec::kNone) {
    // The header's number is the array's length; another one means another extent or type.
    if (first != bytes)
      fail("{}: expected {} bytes, as the extent makes, found {}", path, bytes, first);
    requireRoom(image.header_bytes, bytes);
    found.offset += image.header_bytes;
    return found;
  }

  // Blocks, the length of each and of a shorter last one, and their sizes as stored.
  constexpr uint64_t kFront = 3;
  requireRoom(0, kFront * image.header_bytes);
  CompressedBlocks::Layout layout;
  layout.bytes = bytes;
  layout.blocks = first;
  layout.block_bytes = readNumber(*found.store, found.offset + image.header_bytes, image);
  const uint64_t last = readNumber(*found.store, found.offset + 2 * image.header_bytes, image);
  uint64_t all = 0;
  const bool has_overflow =
      layout.blocks == 0 ||
      __builtin_mul_overflow(layout.blocks - (last > 0 ? 1 : 0), layout.block_bytes, &all) ||
      __builtin_add_overflow(all, last, &all);
  // One shorter block may follow the others; it counts among them.
  if (has_overflow || all != bytes || last > layout.block_bytes ||
      layout.block_bytes > kMostChunkBytes)
    fail("{}: expected blocks of {} bytes together, found {} of {} and a last one of {}", path,
         bytes, layout.blocks, layout.block_bytes, last);
  // Blocks longer than the array would reserve memory that is never used.
  layout.block_bytes = std::min(layout.block_bytes, bytes);
  const uint64_t sizes_bytes = layout.blocks * image.header_bytes;  // at most 8 times `bytes`
  requireRoom(kFront * image.header_bytes, sizes_bytes);
  layout.sizes = layout.data = found.store;
  layout.sizes_at = found.offset + kFront * image.header_bytes;
  layout.data_at = layout.sizes_at + sizes_bytes;
  if (is_text) {  // the blocks are a stretch of base64 by themselves
    const uint64_t header = kFront * image.header_bytes + sizes_bytes;
    layout.data = std::make_shared<Base64Bytes>(file, array.offset + base64Chars(header));
    layout.data_at = 0;
  }
  return {std::make_shared<CompressedBlocks>(std::move(layout), image, path), 0};
}

}  // namespace sluice
