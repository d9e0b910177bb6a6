// SlicePicture: a PNG or TIFF file as rows of scalars, for stacks of slices.
//
// Colors become luminance of the stored numbers (io/files/luminance.h). Alpha is dropped. Row 0 is
// the top row, x grows to the right. One thread at a time uses a SlicePicture.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/slices/page_order.h"
#include "src/base/values/voxel_type.h"

namespace sluice {

// Compressed pieces of a picture that are decoded as a whole: strips, tiles or all of it.
struct CodedPieces {
  int64_t rows = 0;  // 0: the picture is not compressed
  int64_t across = 1;
  friend bool operator==(const CodedPieces&, const CodedPieces&) = default;
};

// A coarser picture of a page: the same in fewer pixels.
struct ReducedFormat {
  int64_t width = 0, height = 0;
  int64_t unit_rows = 1;
  CodedPieces pieces = {};
  friend bool operator==(const ReducedFormat&, const ReducedFormat&) = default;
};

struct PictureFormat {
  int64_t width = 0, height = 0;  // pixels, each 1 to kMaxSide
  int64_t pages = 1;              // pictures in the file, all of this size and type
  VoxelType type = VoxelType::kU8;
  int64_t unit_rows = 1;               // rows that are best read together (tiles); a hint
  CodedPieces pieces = {};             // of the first page
  PageOrder order;                     // meaning of the pages; their number is `pages`
  std::vector<ReducedFormat> reduced;  // that each page has: levels 1, 2, ... of resolution
  // The most bytes that the picture holds while it is open and read: decoders, rows, a strip.
  uint64_t open_bytes = 0;
  std::vector<std::string> notes;            // for VolumeLayout, without the file's name
  std::vector<double> blanked;               // numbers that are read as NaN, see missing_values.h
  double value_scale = 1, value_offset = 0;  // value = stored * value_scale + value_offset

  static constexpr int64_t kMaxSide = 1'000'000;
};

// What was read of a picture file to open it. A file whose tables are known is opened again without
// reading them: a TIFF of thousands of pages has a table for each.
struct PictureTables {
  virtual ~PictureTables() = default;
  PictureFormat format;
};

class SlicePicture {
 public:
  virtual ~SlicePicture() = default;

  // Constant after construction.
  virtual std::shared_ptr<const PictureTables> tables() const = 0;
  const PictureFormat& format() const { return tables()->format; }

  // Rows [first, first + count) of a page, or of one of its reduced pictures if `level` > 0,
  // packed, in format().type and this machine's byte order. Rows are cheapest in ascending order,
  // call after call: compressed ones are decoded from the last row read onward, so a step back
  // starts anew. No more than some rows are held in memory. Requires: the rows exist; out.size()
  // fits. Throws Error when the file is damaged.
  virtual void readRows(int64_t page, size_t level, int64_t first, int64_t count,
                        std::span<std::byte> out) = 0;

  // Bytes taken from the file so far.
  virtual uint64_t storedBytesRead() const = 0;
};

// Whether the file's first bytes are a PNG's or a TIFF's. Throws Error when it cannot be read.
bool isSlicePicture(const std::filesystem::path& path);

// Opens a PNG or TIFF by its first bytes. Throws Error if the file is neither, damaged, or of an
// unsupported kind (the message lists the supported ones). `known`: tables of this file, if it was
// opened before and is still the same; otherwise they are read.
std::unique_ptr<SlicePicture> openSlicePicture(
    const std::filesystem::path& path, const std::shared_ptr<const PictureTables>& known = nullptr);

}  // namespace sluice
