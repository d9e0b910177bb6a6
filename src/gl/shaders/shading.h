// The uniforms for the view, and for gradients, lights and factors (src/device/shading/lighting.h)
// in the shaders' units: texel values, and differences along the volume's axes instead of
// directions, so that a sample is lit without turning its gradient into the world. Pure functions.
#pragma once

#include <array>
#include <vector>

#include "src/device/frame_values.h"
#include "src/device/pictures/picture_rows.h"
#include "src/gl/shaders/gl_program.h"
#include "src/gl/shaders/shaders.h"

namespace sluice {

// The factor from a voxel as the shader reads it to its device value.
double valueScale(DeviceType type);

// The variant that draws the frame's boxes of chunks without spreads, whose texels are voxels.
// `fetches`: ShaderVariant's.
ShaderVariant frameVariant(const FrameSetup& setup, bool fetches);
// The same for boxes of this scale (TexelMap::indexScale()) of a chunk with spreads or without.
ShaderVariant boxVariant(ShaderVariant frame, Vec3d scale, bool has_spread);
// The variant for a box with what it has of BoxDraw::beside and BoxDraw::fade, from that of others.
ShaderVariant besideVariant(const FrameSetup& setup, ShaderVariant of_box, const BoxDraw& box);
// The variant for a box that others join, of chunks with spreads or without.
ShaderVariant withJoined(ShaderVariant of_box, const std::vector<bool>& have_spreads);
// The uniforms of BoxDraw::fade, if the box has it.
void setFade(const BoxDraw& box, GlProgram& program);
// The members of it that channels of one frame share.
ShaderVariant viewVariant(const ShaderVariant& variant);

// Sets what the view is, but for its noise (FrameSetup::jitter). `rows`: those of the picture that
// the target has. Requires: the program is in use.
void setView(const FrameSetup& setup, PictureRows rows, GlProgram& program);

// Sets the uniforms of such a variant. Requires: the program is in use.
void setShading(const FrameSetup& setup, const ShaderVariant& variant, GlProgram& program);

// Sets FrameSetup::depth_cueing. Requires: the program is in use.
void setCueing(const FrameSetup& setup, GlProgram& program);

// Sets what modes need that see values as places in FrameSetup::window; nothing in other modes.
// Requires: the program is in use.
void setWindow(const FrameSetup& setup, GlProgram& program);

}  // namespace sluice
