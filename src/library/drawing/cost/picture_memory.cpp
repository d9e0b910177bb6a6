#include "src/library/drawing/cost/picture_memory.h"

#include <algorithm>

namespace sluice {
namespace {

// Pictures may take one part in this many of the budget.
constexpr uint64_t kPictureShare = 4;

uint64_t writingBytes(PictureSize size) {
  const auto width = static_cast<uint64_t>(size.width);
  const uint64_t pixels =
      // Pictures are converted a few rows at a time, but at least one row, whatever its width.
      std::min(width * static_cast<uint64_t>(size.height), std::max(kWrittenPixels, width));
  return pixels * kWrittenPixelBytes;
}

uint64_t rowBytes(const PictureDemand& picture) {
  return static_cast<uint64_t>(picture.size.width) * picture.pixel_bytes;
}

}  // namespace

PictureDemand pictureDemand(const MachineOptions& machine, const FrameOptions& frame) {
  // Without a request by name, OpenGL runs on a GPU, whose targets are in its own memory.
  const bool in_gl =
      machine.device.device == DeviceChoice::kGl || machine.device.gl != GlChoice::kAuto;
  const bool is_kept = frame.strips != Strips::kMayBe;
  return {frame.size, (in_gl ? kGlPixelBytes : kCpuPixelBytes) + (is_kept ? kKeptPixelBytes : 0),
          frame.occlusion == Occlusion::kOff && !is_kept};
}

uint64_t wholePictureBytes(const PictureDemand& picture) {
  return rowBytes(picture) * static_cast<uint64_t>(picture.size.height) +
         writingBytes(picture.size);
}

uint64_t leastPictureBytes(const PictureDemand& picture) {
  const uint64_t whole = wholePictureBytes(picture);
  if (!picture.in_strips) return whole;
  // A device draws strips of whole steps of rows, so one such step is the least.
  return std::min(whole, rowBytes(picture) * kRowStep + writingBytes(picture.size));
}

uint64_t pictureBytes(const PictureDemand& picture, uint64_t memory_bytes) {
  return std::clamp(memory_bytes / kPictureShare, leastPictureBytes(picture),
                    wholePictureBytes(picture));
}

std::vector<PictureRows> stripsOf(const PictureDemand& picture, uint64_t bytes) {
  const PictureSize size = picture.size;
  // The copy that is being written takes its part first.
  const uint64_t drawing = bytes - std::min(bytes, writingBytes(size));
  const uint64_t fitting = drawing / rowBytes(picture);
  if (!picture.in_strips || fitting >= static_cast<uint64_t>(size.height))
    return {{0, size.height}};
  const int rows = std::max(1, static_cast<int>(fitting / kRowStep)) * kRowStep;
  std::vector<PictureRows> strips;
  // Files are written from the top row down, and row 0 is the lowest, so the highest strip comes
  // first. It alone may be shorter.
  for (int lo = (size.height - 1) / rows * rows; lo >= 0; lo -= rows)
    strips.push_back({lo, std::min(lo + rows, size.height)});
  return strips;
}

}  // namespace sluice
