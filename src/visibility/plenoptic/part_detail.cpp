#include "src/visibility/plenoptic/part_detail.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "src/base/error.h"
#include "src/visibility/plenoptic/extinction.h"

namespace sluice {
namespace {

// Levels in addition to the least, by the byte that holds their number, and the bytes of the cubes'
// bits.
constexpr std::array<size_t, 3> kUpper = {0, 1, 3}, kMaskBytes = {0, 8, 16};

// Another bit per cube must hide at least this share more than the part hides without it.
constexpr float kLeastGain = 0.03F;

// Opacities of packed extinctions, for one voxel length; a gain beyond opaque is nothing.
std::array<float, 256> opacities() {
  std::array<float, 256> values{};
  for (size_t i = 0; i < values.size(); ++i)
    values[i] = -std::expm1(-unpackExtinction(static_cast<uint8_t>(i)));
  return values;
}

// The cubes of a part, relative to it.
Vec3i cubesIn(const PartGrid& cubes, Vec3i part) {
  return min(cubes.count() - part * kDetail, {kDetail, kDetail, kDetail});
}

// The cubes' extinctions, ascending, and how much the level of each hides.
struct Sorted {
  std::array<uint8_t, static_cast<size_t>(kDetail* kDetail* kDetail)> packed{};
  size_t count = 0;
};
struct Cut {
  size_t at = 0;
  float gain = 0;
};

// The cut in [from, end) at which a second level gains most over the level of `from`.
Cut bestCut(const Sorted& cubes, size_t from, size_t end, const std::array<float, 256>& opacity) {
  Cut cut{from, 0};
  for (size_t i = from; i < end; ++i) {
    const float gain =
        // All cubes from i on hide at least as much as cube i, so that the level applies to all of
        // them.
        (opacity[cubes.packed[i]] - opacity[cubes.packed[from]]) * static_cast<float>(end - i);
    if (gain > cut.gain) cut = {i, gain};
  }
  return cut;
}

// By counting: a part has up to 64 of few values, and comparing them would be guesswork for the
// processor.
void sortBytes(std::span<uint8_t> bytes) {
  std::array<uint8_t, 256> counts{};
  for (const uint8_t byte : bytes) ++counts[byte];
  size_t to = 0;
  for (size_t value = 0; to < bytes.size(); ++value)
    for (uint8_t left = counts[value]; left > 0; --left) bytes[to++] = static_cast<uint8_t>(value);
}

// A part with the number of bits that its cubes are worth.
struct Chosen {
  PartLevels part;
  size_t bits = 0;
};
Chosen levelsOf(const uint8_t* first, Vec3i size, int64_t row, int64_t plane, int most_bits) {
  static const std::array<float, 256> kOpacity = opacities();
  Sorted cubes;
  // Rows of whole parts have a length that the compiler knows: a copy is one load and one store.
  const auto copyRow = [&](const uint8_t* from, size_t bytes) {
    std::memcpy(cubes.packed.data() + cubes.count, from, bytes);
    cubes.count += bytes;
  };
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y) {
      const uint8_t* from = first + z * plane + y * row;
      if (size.x == kDetail)
        copyRow(from, kDetail);
      else
        copyRow(from, static_cast<size_t>(size.x));
    }
  // Each byte equals the next one: all are equal, without a loop over them.
  if (std::memcmp(cubes.packed.data(), cubes.packed.data() + 1, cubes.count - 1) == 0)
    return {PartLevels::of(cubes.packed[0]), 0};
  const std::span<uint8_t> packed = std::span(cubes.packed).first(cubes.count);
  const uint8_t least = *std::ranges::min_element(packed);
  Chosen chosen{PartLevels::of(least), 0};
  if (most_bits == 0) return chosen;
  sortBytes(packed);
  float all = 0;
  // The gain is judged by what the cubes hide together.
  for (size_t i = 0; i < cubes.count; ++i) all += kOpacity[cubes.packed[i]];
  const Cut middle = bestCut(cubes, 0, cubes.count, kOpacity);
  if (!(middle.gain > kLeastGain * all)) return chosen;
  chosen.bits = 1;
  std::array<uint8_t, 4>& levels = chosen.part.levels;
  levels = {least, cubes.packed[middle.at], cubes.packed[middle.at], cubes.packed[middle.at]};
  // A second bit cuts both halves once more, each where it gains most.
  const Cut below = bestCut(cubes, 0, middle.at, kOpacity);
  const Cut above = bestCut(cubes, middle.at, cubes.count, kOpacity);
  if (most_bits > 1 && below.gain + above.gain > kLeastGain * all) {
    chosen.bits = 2;
    levels = {least, cubes.packed[below.at], cubes.packed[middle.at], cubes.packed[above.at]};
  }
  for (int64_t z = 0; z < size.z; ++z)
    for (int64_t y = 0; y < size.y; ++y)
      for (int64_t x = 0; x < size.x; ++x) {
        const uint8_t have = first[z * plane + y * row + x];
        uint32_t level = 0;
        // The greatest level that does not exceed the cube's own, so that it hides no more than it
        // does.
        for (uint32_t i = 1; i <= kUpper[chosen.bits]; ++i)
          if (levels[i] <= have) level = i;
        chosen.part.cubes[static_cast<size_t>(z)] |= level << (2 * (y * kDetail + x));
      }
  return chosen;
}

void append(std::vector<uint8_t>& bytes, const Chosen& chosen) {
  const PartLevels& part = chosen.part;
  bytes.push_back(static_cast<uint8_t>(chosen.bits));
  for (size_t i = 1; i <= kUpper[chosen.bits]; ++i) bytes.push_back(part.levels[i]);
  for (const uint32_t layer : part.cubes) {
    uint32_t kept = layer;
    if (chosen.bits == 1) {
      kept = 0;
      // One bit of the two is enough for two levels.
      for (unsigned cube = 0; cube < 16; ++cube) kept |= (layer >> (2 * cube) & 1U) << cube;
    }
    for (size_t i = 0; i < kMaskBytes[chosen.bits] / 4; ++i)
      bytes.push_back(static_cast<uint8_t>(kept >> (8 * i)));
  }
}

// A bit a cube as two.
uint32_t spread(uint32_t bits) {
  bits = (bits | bits << 8U) & 0x00ff00ffU;
  bits = (bits | bits << 4U) & 0x0f0f0f0fU;
  bits = (bits | bits << 2U) & 0x33333333U;
  return (bits | bits << 1U) & 0x55555555U;
}

}  // namespace

PartLevels DetailReader::next() {
  PartLevels part = PartLevels::of(parts_[part_++]);
  if (detail_.empty()) return part;
  const size_t bits = detail_[at_++];
  if (bits == 0) return part;
  for (size_t i = 1; i < part.levels.size(); ++i)
    // With one bit, the upper levels are all the same.
    part.levels[i] = detail_[at_ + std::min(i, kUpper[bits]) - 1];
  at_ += kUpper[bits];
  for (uint32_t& layer : part.cubes) {
    uint32_t kept = 0;
    for (size_t i = 0; i < kMaskBytes[bits] / 4; ++i)
      kept |= static_cast<uint32_t>(detail_[at_ + i]) << (8 * i);
    at_ += kMaskBytes[bits] / 4;
    layer = bits == 1 ? spread(kept) : kept;
  }
  return part;
}

bool detailFits(std::span<const uint8_t> parts, std::span<const uint8_t> detail) {
  if (detail.empty()) return true;
  size_t at = 0;
  for (const uint8_t least : parts) {
    // Bytes from a file are not believed: reading goes no further than they do.
    if (at >= detail.size() || detail[at] > kMostDetailBits) return false;
    const size_t bits = detail[at++];
    if (kUpper[bits] + kMaskBytes[bits] > detail.size() - at) return false;
    const auto upper = detail.subspan(at, kUpper[bits]);
    // Levels ascend from the least, as readers of the cubes rely on.
    if (!std::is_sorted(upper.begin(), upper.end())) return false;
    if (!upper.empty() && upper.front() < least) return false;
    at += kUpper[bits] + kMaskBytes[bits];
  }
  return at == detail.size();
}

PartGrid partsOfCubes(const PartGrid& cubes) {
  return {cubes.cells, cubes.side * kDetail};
}

DetailedParts detailedParts(const PartGrid& cubes, std::span<const uint8_t> packed, int bits) {
  const Vec3i size = cubes.count(), count = partsOfCubes(cubes).count();
  SLUICE_CHECK_EQ(static_cast<int64_t>(packed.size()), volume(size));
  DetailedParts result;
  bool has_detail = false;
  for (int64_t z = 0; z < count.z; ++z)
    for (int64_t y = 0; y < count.y; ++y)
      for (int64_t x = 0; x < count.x; ++x) {
        const Vec3i lo = Vec3i{x, y, z} * kDetail;
        const Chosen chosen = levelsOf(packed.data() + (lo.z * size.y + lo.y) * size.x + lo.x,
                                       cubesIn(cubes, {x, y, z}), size.x, size.x * size.y, bits);
        result.parts.push_back(chosen.part.levels[0]);
        append(result.detail, chosen);
        has_detail = has_detail || chosen.bits > 0;
      }
  if (!has_detail) result.detail.clear();
  return result;
}

std::vector<uint8_t> cubesOf(const PartGrid& cubes, std::span<const uint8_t> parts,
                             std::span<const uint8_t> detail) {
  const Vec3i size = cubes.count(), count = partsOfCubes(cubes).count();
  std::vector<uint8_t> packed(static_cast<size_t>(volume(size)));
  DetailReader in(parts, detail);
  for (int64_t z = 0; z < count.z; ++z)
    for (int64_t y = 0; y < count.y; ++y)
      for (int64_t x = 0; x < count.x; ++x) {
        const PartLevels part = in.next();
        const Vec3i lo = Vec3i{x, y, z} * kDetail, in_part = cubesIn(cubes, {x, y, z});
        for (int64_t k = 0; k < in_part.z; ++k)
          for (int64_t j = 0; j < in_part.y; ++j)
            for (int64_t i = 0; i < in_part.x; ++i)
              packed[static_cast<size_t>(((lo.z + k) * size.y + lo.y + j) * size.x + lo.x + i)] =
                  part.levels[part.cubes[static_cast<size_t>(k)] >> (2 * (j * kDetail + i)) & 3U];
      }
  return packed;
}

}  // namespace sluice
