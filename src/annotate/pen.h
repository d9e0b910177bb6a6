// Pen: lines, areas and words over a picture, each with a rim that keeps it legible on anything.
// All lengths are pixels from the upper left corner. One thread.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "src/base/values/picture.h"
#include "src/base/values/vec.h"

namespace sluice {

struct Point {
  double x = 0, y = 0;
};

// The end of a word that lies at its point; vertically its middle lies there.
enum class Anchor { kLeft, kMiddle, kRight };

class Pen {
 public:
  // `em`: the size of letters. `light_below`: what lies below is light, so that the ink is dark.
  // The canvas is a strip whose top is `first_row` pixels below the corner that lengths count from.
  // Throws Error when no font is installed.
  Pen(int width, int height, double em, bool light_below, int first_row = 0);
  ~Pen();
  Pen(const Pen&) = delete;
  Pen& operator=(const Pen&) = delete;

  double em() const { return em_; }
  Vec3d ink() const { return ink_; }
  void word(Point at, Anchor anchor, const std::string& text, Vec3d rgb);
  double widthOf(const std::string& text) const;
  // A line with round ends.
  void line(const std::vector<Point>& through, double width, Vec3d rgb);
  void area(const std::vector<Point>& corners, Vec3d rgb);  // without a rim
  // The picture with what was drawn over it.
  Picture over(const Picture& picture) const;

 private:
  struct Canvas;
  const double em_;
  Vec3d ink_, rim_;
  std::unique_ptr<Canvas> canvas_;
};

}  // namespace sluice
