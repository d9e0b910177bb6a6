// PartDetail: the places in a part of a block that hide more than the part's least extinction
// tells.
//
// A part is kDetail^3 cubes. Besides the least extinction of all its cubes, it stores a greater one
// and a bit for each cube: the cubes with the bit have at least the greater one. If an opaque
// surface passes through a part, so that its least extinction is 0, this describes it nearly
// completely, in ten bytes. Parts whose cubes differ more, as in translucent matter, store three
// greater extinctions and two bits a cube. A part whose cubes are alike costs one byte more. Pure
// functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "src/visibility/plenoptic/block_parts.h"

namespace sluice {

inline constexpr int64_t kDetail = 4;      // cubes a side of a part
inline constexpr int kMostDetailBits = 2;  // a cube

// Extinctions packed as in extinction.h.
struct PartLevels {
  std::array<uint8_t, 4> levels{};        // ascending; all equal: only the least is known
  std::array<uint32_t, kDetail> cubes{};  // for each layer z, 2 bits at 2 (y kDetail + x): a level
  static PartLevels of(uint8_t least) { return {{least, least, least, least}, {}}; }
  friend bool operator==(const PartLevels&, const PartLevels&) = default;
};

// Part after part, as bytes.
class DetailReader {
 public:
  // `parts`: of each part the least. `detail` empty: no part has any.
  DetailReader(std::span<const uint8_t> parts, std::span<const uint8_t> detail)
      : parts_(parts), detail_(detail) {}
  // Requires: not all parts are read, and detailFits().
  PartLevels next();

 private:
  std::span<const uint8_t> parts_, detail_;
  size_t part_ = 0, at_ = 0;
};
// Whether the bytes are the detail of these parts, as DetailReader supposes. Those of a file may
// not be.
bool detailFits(std::span<const uint8_t> parts, std::span<const uint8_t> detail);

// The parts of a block whose cubes' extinctions are known: kDetail cubes a side.
PartGrid partsOfCubes(const PartGrid& cubes);
struct DetailedParts {
  std::vector<uint8_t> parts;   // the least of each, x fastest
  std::vector<uint8_t> detail;  // empty if no part has any
};
// `bits` of a cube are kept at the most, 0 to kMostDetailBits.
DetailedParts detailedParts(const PartGrid& cubes, std::span<const uint8_t> packed, int bits);
// The extinction known of each cube, unpacked, x fastest.
std::vector<uint8_t> cubesOf(const PartGrid& cubes, std::span<const uint8_t> parts,
                             std::span<const uint8_t> detail);

}  // namespace sluice
