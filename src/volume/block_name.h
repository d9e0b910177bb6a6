// BlockName: the name of a volume block among blocks of several time steps, levels of resolution or
// channels. It keys the volume buffer, object blocks, texture blocks, runs that are read together
// and the recipes of chunks. A plain value.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

namespace sluice {

struct BlockName {
  int64_t time = 0;
  int32_t level = 0;    // in the pyramid, 0 the finest
  int32_t channel = 0;  // 0: the one that the source reads
  int64_t block = 0;    // id in the layout of that level

  friend auto operator<=>(const BlockName&, const BlockName&) = default;

  // Blocks of one grid: only their ids differ.
  bool isBeside(const BlockName& other) const {
    return time == other.time && level == other.level && channel == other.channel;
  }
  // The name of another block of the same grid.
  BlockName withBlock(int64_t other) const { return {time, level, channel, other}; }
};

struct BlockNameHash {
  size_t operator()(const BlockName& name) const {
    const auto mixed = [](int64_t number, uint64_t factor) {
      return static_cast<uint64_t>(number) * factor;
    };
    return static_cast<size_t>(
        mixed(name.time, 0x9e3779b97f4a7c15U) ^ mixed(name.block, 0xff51afd7ed558ccdU) ^
        mixed(name.level, 0xc4ceb9fe1a85ec53U) ^ mixed(name.channel, 0xbf58476d1ce4e5b9U));
  }
};

}  // namespace sluice
