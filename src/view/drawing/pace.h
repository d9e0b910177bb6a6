// Pace: how large a picture, and how far apart its samples, may be so that a frame takes no longer
// than it may; from what the last ones took. Plain data, pure functions.
#pragma once

namespace sluice {

// What frames took of late.
struct Pace {
  double pixel_s = 0;  // drawing, a pixel at a step of 1 voxel
  double fixed_s = 0;  // what does not depend on the picture's size: classes, plans, copies
  bool isKnown() const { return pixel_s > 0; }
};

struct DrawnFrame {
  double pixels = 1;
  double step_vox = 1;
  double draw_s = 0;   // drawing alone
  double other_s = 0;  // the rest
};
// With one more frame. Slower ones count at once, faster ones over a few frames, so that the size
// does not flicker.
Pace learned(Pace pace, const DrawnFrame& frame);

struct Quality {
  double scale = 1;        // of width and height, one of a few
  double step_factor = 1;  // times the step of the complete picture
  bool isFull() const { return scale == 1 && step_factor == 1; }
};
// The best that is expected to take at most `budget_s`, or else the least; of `pixels` and
// `step_vox` of the complete picture. Where nothing is known yet, a quarter of the size.
Quality qualityWithin(const Pace& pace, double pixels, double step_vox, double budget_s);
// Of a frame's budget, what drawing may take where showing takes the rest; at least a third.
double drawingBudget(double budget_s, double showing_s);
// What is expected of it.
double expectedSeconds(const Pace& pace, const Quality& quality, double pixels, double step_vox);

}  // namespace sluice
