// Pace: the size of the picture and the distance of its samples that keep a frame within its time,
// learned from the last frames. Plain data, pure functions.
#pragma once

namespace sluice {

// Times of recent frames.
struct Pace {
  double pixel_s = 0;          // drawing, a pixel at a step of 1 voxel
  double pixel_convert_s = 0;  // turning a drawn pixel into bytes, whatever the step
  double fixed_s = 0;  // time that does not depend on the picture's size: classes, plans, copies
  bool isKnown() const { return pixel_s > 0; }
};

struct DrawnFrame {
  double pixels = 1;
  double step_vox = 1;
  double draw_s = 0;     // drawing alone
  double convert_s = 0;  // turning the picture into bytes
  double other_s = 0;    // the rest
};
// The pace with one more frame. Slower ones count at once, faster ones over a few frames, so that
// the size does not flicker.
Pace learned(Pace pace, const DrawnFrame& frame);

struct Quality {
  double scale = 1;        // factor of width and height, one of a few
  double step_factor = 1;  // times the step of the complete picture
  bool isFull() const { return scale == 1 && step_factor == 1; }
};
// The distance between samples of pictures that are smaller than the complete one: by the table of
// qualities, or, with levels of resolution, as wide as their pixels.
enum class PreviewSteps { kFixed, kFollowPixels };
// The best quality that is expected to take at most `budget_s`, or else the lowest; `pixels` and
// `step_vox` are those of the complete picture. A quarter of the size if the pace is not known yet.
Quality qualityWithin(const Pace& pace, double pixels, double step_vox, double budget_s,
                      PreviewSteps steps = PreviewSteps::kFixed);
// The part of a frame's budget for drawing if showing takes the rest; at least a third.
double drawingBudget(double budget_s, double showing_s);
// Expected time of a frame.
double expectedSeconds(const Pace& pace, const Quality& quality, double pixels, double step_vox);

}  // namespace sluice
