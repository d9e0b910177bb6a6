// Rows of a picture: large pictures are drawn strip by strip, so that only a strip is in memory.
#pragma once

#include <optional>

#include "src/device/frame_values.h"

namespace sluice {

class Device;

// Rows from `lo` on, `hi` is not one of them; counted upwards from the lower edge, as rays are.
struct PictureRows {
  int lo = 0, hi = 0;
};
// Strips begin and end at multiples of this, or at the edges of the picture.
inline constexpr int kRowStep = 32;

// A second interface of devices that can draw some rows of a picture only. The device's thread.
class DrawsRows {
 public:
  virtual ~DrawsRows() = default;
  // From the next frame on pictures show only these rows, and each pixel equals that of the whole
  // picture, bit by bit: FrameSetup::size stays the whole picture's. nullopt: all rows. Not for
  // parts. Requires: bounds at kRowStep.
  virtual void drawRows(std::optional<PictureRows> rows) = 0;
  virtual std::optional<PictureRows> rows() const = 0;
};

// Makes a device draw strips of its pictures. After its end the device draws whole pictures again.
class StripsOfDevice {
 public:
  // Requires: the device implements DrawsRows.
  explicit StripsOfDevice(Device& device);
  ~StripsOfDevice();
  StripsOfDevice(const StripsOfDevice&) = delete;
  StripsOfDevice& operator=(const StripsOfDevice&) = delete;

  // The next frame shows these rows.
  void draw(PictureRows rows) { device_->drawRows(rows); }

 private:
  DrawsRows* const device_;
};

// The rows that a frame of the device shows; nullopt: all.
std::optional<PictureRows> rowsOf(const Device& device);
// The rows whose rays may meet a box of cells.
PictureRows rowsOf(const FrameSetup& setup, const Box3& cells);
inline bool overlap(PictureRows a, PictureRows b) {
  return a.lo < b.hi && b.lo < a.hi;
}

}  // namespace sluice
