// The device's shaders: one source with variants, since every branch not taken in a sampling loop
// is time saved in each sample.
#pragma once

#include <string>
#include <vector>

#include "src/device/frame_values.h"

namespace sluice {

// Selects the loop's body. Two frames with equal variants share a program.
struct ShaderVariant {
  Combining combining = Combining::kBlend;
  bool perspective = false;
  bool lit = false;
  bool with_depth = false;
  bool stops_early = false;
  bool floats = false;        // texels may be such that stand for NaN
  bool counts_taken = false;  // also writes the number of samples
  bool counts = false;        // writes the number of samples, samples nothing
  int clip_planes = 0;
  int shininess = 0;          // lit: the exponent if it is a small whole number, otherwise 0
  int gradient_rows = 0;      // rows of gradient factors; 0: the opacity follows from values
  bool factor_table = false;  // factors depend on the value too
  bool corrects = false;      // with factors or labels: a sample's length is not the opacity's
  bool goes_ahead = false;    // leaves out samples that show nothing
  bool labels = false;        // values are names, see LookUp
  bool label_table = false;   // the look-up is one of labels, in rows, whatever the values are
  bool planes = false;        // samples lie on voxel planes, see FrameSetup
  bool codes_depth = false;   // the greatest value is kept with its depth, see depth_code.h
  bool spread = false;        // chunks have spreads, see ExpectedLook
  bool shares = false;        // of labels: chunks have shares, see ChunkTexels
  bool scaled = false;        // texels are not voxels, see TexelMap
  bool integrates = false;    // segments in place of samples, see FrameSetup
  int surfaces = 0;           // how many surfaces there are, see FrameSetup
  bool has_opacities = true;  // with surfaces: the look-up shows something else, too
  bool only_opaque = false;   // surfaces: see BoxDraw::beside
  bool fades = false;         // with surfaces: see BoxDraw::fade
  // With surfaces: how many boxes join each one, and which of them have spreads, by bits. Their
  // uniforms end in "_0", "_1", ...
  int joined = 0, joined_spreads = 0;
  bool light_volume = false;  // lit: light arrives as FrameSetup::light has it
  bool cues_depth = false;    // far colours are darkened, see FrameSetup::depth_cueing
  bool jitters = false;       // slices are moved along the ray, see FrameSetup::jitter
  bool oblique = false;       // with gradients: the volume's axes are not at right angles
  bool fetches = false;       // the hardware interpolates coarsely, see filtersExactly()
  bool rough_first = false;   // fetches: only if the hardware's value may show something
  friend auto operator<=>(const ShaderVariant&, const ShaderVariant&) = default;
};

// The variant of a box that joins another one, which has `of`.
ShaderVariant joinedVariant(const ShaderVariant& of, int number);

// Boxes come as kTexelsPerBox RGBA32F texels each of a buffer texture; see box_buffer.h.
std::string vertexShader(const ShaderVariant& variant);
std::string fragmentShader(const ShaderVariant& variant);

// The variant of a frame that blends channels (FrameSetup::others). `view` has the members that
// they share. A uniform that each channel has ends in "_0", "_1", ... Boxes come in groups, see
// inGroups().
struct BlendedVariant {
  ShaderVariant view;
  std::vector<ShaderVariant> channels;
  friend auto operator<=>(const BlendedVariant&, const BlendedVariant&) = default;
};
std::string blendedVertexShader(const BlendedVariant& variant);
std::string blendedFragmentShader(const BlendedVariant& variant);

}  // namespace sluice
