// The picture of several channels: the sum of the pictures of each, as light of several lamps adds
// up and as fluorescence microscopists combine channels.
//
// Colours are added as the pictures hold them: sRGB values as displays show them, premultiplied by
// the opacity. So are opacities. The sums are limited to 1 at the end (the operator "plus" of
// Porter and Duff). The depth of a pixel is the mean of its depths, weighted by the opacities.
#pragma once

#include "src/base/threads/worker_pool.h"
#include "src/base/values/picture.h"

namespace sluice {

// Adds a picture to a sum that is not limited yet. The sum of any number of pictures does not
// depend on their order, but for rounding. Requires: pictures of one size, both with depth or
// neither.
void addPicture(Picture& sum, const Picture& more, WorkerPool& pool);
// Limits the sum of all pictures to 1.
void limitSum(Picture& sum, WorkerPool& pool);

}  // namespace sluice
