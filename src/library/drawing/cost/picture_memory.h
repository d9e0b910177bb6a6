// The part of --memory that a picture takes while it is drawn and written, and the strips in which
// a picture is drawn that would take too much. Pure functions.
#pragma once

#include <cstdint>
#include <vector>

#include "src/device/pictures/picture_rows.h"
#include "src/library/requests.h"
#include "src/render/camera/frame_options.h"

namespace sluice {

// Bytes of a pixel while it is drawn. The CPU device has tiles with opacity, stops and depths, and
// the picture with its depths. OpenGL in memory has two float targets and their copies, too.
inline constexpr uint64_t kCpuPixelBytes = (6 + 5) * sizeof(float);
inline constexpr uint64_t kGlPixelBytes = 68;
// Bytes of a pixel of a whole picture that is looked at while another is drawn: colours and depth.
inline constexpr uint64_t kKeptPixelBytes = 5 * sizeof(float);
// Bytes of a pixel on the first rank, if several ranks compose the picture: colours and depth.
inline constexpr uint64_t kComposedPixelBytes = 5 * sizeof(float);
// Pixels of a few rows on their way to a file, and the bytes of each.
inline constexpr uint64_t kWrittenPixels = uint64_t{1} << 15;
inline constexpr uint64_t kWrittenPixelBytes = 80;

// The memory demand of a picture.
struct PictureDemand {
  PictureSize size{0, 0};
  uint64_t pixel_bytes = kCpuPixelBytes;
  bool in_strips = true;  // some of its rows may be drawn by themselves
};
// With occlusion a picture is drawn whole: the opacity maps of a strip differ from those of the
// picture, and so do the rays that end early. A picture that is kept whole while others are drawn
// is counted beside these.
PictureDemand pictureDemand(const MachineOptions& machine, const FrameOptions& frame);

// Bytes of the whole picture, with the rows that are being written.
uint64_t wholePictureBytes(const PictureDemand& picture);
// The least bytes that it can be drawn with: kRowStep rows.
uint64_t leastPictureBytes(const PictureDemand& picture);
// Bytes of the whole picture, or a quarter of `memory_bytes` if that is less, but at least
// leastPictureBytes().
uint64_t pictureBytes(const PictureDemand& picture, uint64_t memory_bytes);

// Strips from the top of the picture down, each of at most `bytes`; one strip if the whole picture
// fits. Requires: bytes >= leastPictureBytes().
std::vector<PictureRows> stripsOf(const PictureDemand& picture, uint64_t bytes);

}  // namespace sluice
