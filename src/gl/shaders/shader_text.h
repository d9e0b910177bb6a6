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
extern const char* const kRayText;         // Ray, rayAt(pixel)
extern const char* const kIntervalText;    // ivec2 slices(origin, step)
extern const char* const kWayText;         // enterBox(pixel, ray): range, first, along
extern const char* const kPlanesText;      // ivec2 planes(pixel, ...): slices() of voxel planes
extern const char* const kTexelText;       // the values, gradients and spreads of a place
extern const char* const kColorText;       // the look-up, factors, light
extern const char* const kLabelText;       // a place's labels, what shows of them, their slopes
extern const char* const kShownColorText;  // the colour of a sample
extern const char* const kSumText;         // what a pixel keeps and writes; blend(color, slice)
extern const char* const kCountText;       // main: how many samples there are

// These two say where the samples of a ray lie, by enter(pixel, ray), which sets `range` or
// discards the pixel, and placeAt(k).
extern const char* const kSliceSamplesText;
extern const char* const kPlaneSamplesText;  // also voxelAt(k)

// These say what a sample is, by enterSamples(), and nextSample(k, ray), which moves k on to the
// next sample that may show, at most to the last one.
extern const char* const kLightPlaceText;  // lightAt(ray, slice): a place in the light volume
extern const char* const kSampleText;      // Sample; sampleAt(...): the sample of one value
extern const char* const kValuesText;      // each is of one value
extern const char* const kSegmentsText;    // each is of the values between two places
extern const char* const kSurfaceText;     // where a surface lies, and its colour
extern const char* const kSurfacesText;    // each may have surfaces, which combine() blends with it
// Surfaces of boxes that join one another: addMet(k, ray) lists those that a slice meets in a box,
// and mayMeetIn(k) tells of a box that joins whether there may be any.
extern const char* const kMetText;
extern const char* const kJoinedText;

// These say how a pixel combines its samples, by beginSum(ray) and combine(sample, k, ray).
extern const char* const kBlendText;
extern const char* const kGreatestText;
extern const char* const kLeastText;
extern const char* const kAverageText;
extern const char* const kAttenuatedText;
extern const char* const kDepthCodeText;

extern const char* const kSampleMainText;  // main: combines all samples

// Several channels as one medium.
extern const char* const kBlendedVertexText;  // main: the outline of a block in the picture
extern const char* const kChannelText;        // a channel's samples
extern const char* const kBlendedText;        // main: blends the channels' samples

}  // namespace sluice
