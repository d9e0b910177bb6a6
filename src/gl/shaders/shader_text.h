// The text of the shaders in GLSL, in parts, which shaders.cpp puts together behind its version and
// the variant's definitions. A pixel's way through a box: the vertices give it the box, the
// interval the slices inside, and a main function takes the samples or counts them.
#pragma once

namespace sluice {

extern const char* const kCoverText;  // main, of vertices: three that cover the whole target

extern const char* const kViewInputsText;  // values that pass from vertices to pixels: of the view,
extern const char* const kBoxInputsText;   // and of a box
extern const char* const kReadViewText;    // readView(): sets the first,
extern const char* const kReadBoxText;     // readBox(at): and the second
extern const char* const kVertexText;      // main: the outline of a box in the picture
extern const char* const kRayText;         // jitterAt(pixel), sliceAt(t, step), rayLengthAt(pixel)
extern const char* const kIntervalText;    // ivec2 slices(origin, step)
extern const char* const kPlanesText;      // ivec2 planes(pixel, ...): the same of voxel planes
extern const char* const kOutputsText;     // what is written beside the colour; cued(color, slice)
extern const char* const kTexelText;       // the values, gradients and spreads of a place
extern const char* const kColorText;       // the look-up, factors, light
extern const char* const kLabelText;  // the labels of a place, what shows of them, their slopes
extern const char* const kShownColorText;  // the colour of a sample
extern const char* const kSurfaceText;     // surfaces where values pass a level
extern const char* const kSampleText;      // main: looks up, lights and blends the samples
extern const char* const kCountText;       // main: how many samples there are

// Several channels as one medium.
extern const char* const kBlendedVertexText;  // main: the outline of a block in the picture
extern const char* const kChannelText;        // a channel's box and samples
extern const char* const kBlendedText;        // main: blends the channels' samples

}  // namespace sluice
