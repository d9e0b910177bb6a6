// The picture of a test that has to be right: as the reference renderer has it, whatever the blocks
// are.
#pragma once

#include <gtest/gtest.h>

#include "tests/render/render_scene.h"

namespace sluice {

class RightPictureTest : public RenderTest {
 protected:
  // Draws with blocks of 8 voxels, of 32, whole, and without leaps. `of_reference`: the same
  // options for the reference, with the step that such frames have.
  void expectRightPicture(VolumeSource& source, const TransferFunction& transfer,
                          FrameOptions options, const FrameOptions& of_reference, bool lit) {
    constexpr double kOfReference = 2, kSame = 1;
    RenderScene scene(device(), source, transfer, {.block_vox = 8, .lit = lit, .ghost = true});
    FloatPicture drawn = scene.draw(options);
    EXPECT_GE(shownShare(drawn), 0.05);
    const FloatPicture reference = scene.reference(of_reference);
    EXPECT_TRUE(within(kOfReference, drawn, reference));
    // Of two values that are almost the greatest, rounding may choose the depth that shows.
    if (traitsOf(options.mode).codes_depth) drawn.doubt = reference.doubt;
    RenderScene large(device(), source, transfer, {.block_vox = 32, .lit = lit, .ghost = true});
    EXPECT_TRUE(within(kSame, drawn, large.draw(options))) << "blocks of another size";
    options.algorithm = Algorithm::kConventional;
    EXPECT_TRUE(within(kSame, drawn, scene.draw(options))) << "whole blocks";
    options.skipping = Skipping::kShading;
    EXPECT_TRUE(within(kSame, drawn, large.draw(options))) << "without leaps";
  }
};

}  // namespace sluice
