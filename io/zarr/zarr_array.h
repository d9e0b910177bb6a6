// ZarrArray: the contents of the .zarray of a Zarr v2 array, checked: shape, chunks, type, codec,
// fill.
//
// A Zarr array is a folder of chunk files, all of one shape, those at the upper ends padded; a
// chunk that equals the fill value throughout need not exist. Plain values; nothing here touches a
// file, so that the parser can be fuzzed. Source: the Zarr storage specification, version 2.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/values/voxel_type.h"

namespace sluice {

enum class ZarrCodec { kNone, kBlosc, kDeflate, kZstd };  // kDeflate: zlib or gzip

struct ZarrArray {
  // In the file's order: axis 0 is the slowest (for `fortran_order`, the fastest inside a chunk).
  std::vector<int64_t> shape, chunks;
  VoxelType type = VoxelType::kU8;
  std::endian byte_order = std::endian::little;
  ZarrCodec codec = ZarrCodec::kNone;
  double fill_value = 0;  // value of missing chunks, of `type`
  bool fortran_order = false;
  char separator = '.';            // between the numbers of a chunk's name
  std::vector<std::string> notes;  // for people, one line each: members that mean nothing

  size_t axes() const { return shape.size(); }
  uint64_t chunkBytes() const;  // decoded; at most kMostChunkBytes
  // Chunks along an axis, and of the whole array.
  int64_t chunksAlong(size_t axis) const;
  int64_t chunkCount() const;
  // Chunks are numbered with the last axis fastest. Requires: inside the array.
  int64_t chunkNumber(std::span<const int64_t> index) const;
  std::vector<int64_t> chunkIndex(int64_t number) const;
  // The chunk's file relative to the array's folder: "0.3.1" or "0/3/1".
  std::string chunkName(int64_t number) const;
};

// Blosc's limit for a buffer.
constexpr uint64_t kMostChunkBytes = (uint64_t{1} << 31) - 17;
constexpr size_t kMostZarrAxes = 5;

// Throws Error, which starts with `path`, when the text is no .zarray, or one of an array that
// cannot be read: filters, more than 5 axes, types other than integers of 8 to 32 bits and floats
// of 32 and 64 (bool is read as u8), other codecs.
ZarrArray parseZarrArray(std::string_view text, const std::string& path);

}  // namespace sluice
