// TextVoxels: numbers written as text, separated by white space or commas, as voxels in memory.
//
// Holds a fixed 64 KiB of text. One thread.
#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "io/files/decoder.h"
#include "io/files/file.h"
#include "src/base/values/voxel_type.h"

namespace sluice {

class TextVoxels : public Decoder {
 public:
  // The text starts at `offset` and lasts to `end`, or the end of the file.
  TextVoxels(std::shared_ptr<File> file, uint64_t offset, VoxelType type,
             uint64_t end = UINT64_MAX);

  // Throws Error for text that is no number, or a number that the type cannot hold.
  size_t read(std::span<std::byte> out) override;
  bool finished() const override { return true; }

 private:
  // Empty at the end; valid until the next call.
  std::string_view nextToken();
  bool refill();

  const std::shared_ptr<File> file_;
  const VoxelType type_;
  const uint64_t text_end_;
  uint64_t offset_;             // offset of the first byte not yet in text_
  size_t begin_ = 0, end_ = 0;  // unread part of text_
  std::array<char, 64 * 1024> text_;
};

}  // namespace sluice
