// --verify: how far a picture is from the plain one.
//
// The plain picture shares only the request with the picture that it checks. The volume is opened
// again and its ranges are read from the voxels, in blocks of another size. The view is fitted to
// those. The finest level is drawn, whatever levels the picture was drawn from. Every block is
// drawn whole, also those that show nothing, every sample of a ray is taken, and nothing is left
// out for time. Of a picture with several rays a pixel (--keep-thin) the plain one has the same
// rays, each drawn as a picture of its own. Both pictures share the transfer function and the
// device.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/library/drawing/view_fit.h"
#include "tools/scene/open_scene.h"

namespace sluice {

struct Verification {
  double max_difference = 0, mean_difference = 0;  // in 1/255
  int64_t differing_pixels = 0;                    // pixels that differ by more than 1/255
  std::vector<std::string> unchecked;              // the inputs that both pictures share
};

// The picture to check.
struct VerifiedView {
  const VolumeArguments& volume;  // its time is the step that the look and the fit are of
  const ResourceArguments& resources;
  std::vector<Camera> cameras;  // for all frames, before they were fitted
  size_t frame = 0;             // the frame of the picture
  FitChoice fit;
  Room room;
  bool this_step = false;
  int64_t time = 0;                     // the step that the picture shows
  bool has_step = false;                // the user set the distance of slices
  std::vector<LayerFrame> layers = {};  // the reports of the picture
};

// `options` belong to the picture. Draws the scene's last picture: the scene's session is gone
// afterwards. With several ranks, a single rank does it. Throws Error, Interrupted.
Verification verify(Scene& scene, const VerifiedView& view, FrameOptions options,
                    const Picture& picture);

}  // namespace sluice
