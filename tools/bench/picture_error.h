// How far a picture is from the truth: the numbers that `sluice bench levels` prints. Pure
// functions.
#pragma once

#include "src/base/values/picture.h"

namespace sluice {

struct PictureError {
  double max = 0, mean = 0;  // of a channel, premultiplied, in units of 1/255
  double ssim = 0;           // of red, green and blue over black, 1 for equal pictures
  double mean_opacity = 0;   // difference of the mean opacities, in parts of the truth's
  // Fine detail of each picture where the truth has little: root mean square, in units of 1/255, of
  // red, green and blue without their blur, over that half of the pixels with opacity where the
  // truth has least. Rings and other moire on smooth surfaces raise the first above the second.
  double detail = 0, truth_detail = 0;
};

// Structural similarity after Wang, Bovik, Sheikh and Simoncelli 2004: a Gaussian window of 11 x 11
// pixels with a standard deviation of 1.5, cut at the picture's border, and their constants. The
// blur has the same window: it leaves frequencies above about a tenth of a cycle a pixel.
// Requires: pictures of one size, not empty.
PictureError pictureError(const Picture& picture, const Picture& truth);

// Each pixel is the mean of `times` x `times` pixels. Requires: `times` divides width and height.
Picture averagedDown(const Picture& picture, int times);

}  // namespace sluice
