// BlendedDrawing: draws frames that blend several channels as one medium (FrameSetup::others). The
// shader walks the view's slices through all boxes of a block together, with a texture and a look
// for each channel. One thread, the context's.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "src/device/frame_values.h"
#include "src/gl/contexts/gl_functions.h"
#include "src/gl/look_textures.h"
#include "src/gl/shaders/gl_program.h"
#include "src/gl/shaders/shaders.h"

namespace sluice {

// Blocks that one call draws: the hull of each one's boxes, and all of their boxes, `channels` a
// block, an empty one for each channel that the block lacks. All are of one scale
// (TexelMap::indexScale()), and each channel's boxes are of one chunk.
struct BlendedBlocks {
  std::vector<BoxDraw> hulls, boxes;
  std::vector<std::optional<uint64_t>> chunks;  // of each channel that has a box
};

// The first blocks of `boxes`, which it moves on, that can be drawn together.
BlendedBlocks takeBlocks(std::span<const BoxDraw>& boxes, size_t channels);

// The boxes of blocks as the shader reads them (BoxBuffer): of each block its hull and its
// channels.
std::vector<BoxDraw> inGroups(const BlendedBlocks& blocks, size_t first, size_t count);

class BlendedDrawing {
 public:
  // `gl` must outlive it. `texture_units`: as many as the driver has.
  BlendedDrawing(const GlFunctions& gl, int texture_units)
      : gl_(gl), texture_units_(texture_units) {}

  // Begins a frame, whose setup must outlive it. `fetches`: ShaderVariant's. Throws Error if the
  // driver has too few texture units.
  void begin(const FrameSetup& setup, bool fetches);
  // The frame's program for blocks of this scale is in use from now on. `has_spread`: of each
  // channel, whether its chunk has spreads; nullopt: it has none. `tell` tells a program that does
  // not know it of the view.
  void use(Vec3d scale, const std::vector<std::optional<bool>>& has_spread,
           const std::function<void(GlProgram&)>& tell);
  // Binds the channel's texture, and tells the program of its size.
  void bindChunk(size_t channel, GLuint texture, Vec3i storage_vox);

 private:
  const GlFunctions& gl_;
  const int texture_units_;
  std::map<BlendedVariant, std::unique_ptr<GlProgram>> programs_;
  std::set<BlendedVariant> told_;            // of this frame
  std::vector<const FrameSetup*> channels_;  // of this frame
  std::vector<ShaderVariant> variants_;      // of each channel, of boxes of the finest level
  std::vector<LookUnits> look_units_;
  std::vector<std::unique_ptr<LookTextures>> looks_;  // of each channel
  std::vector<GLenum> chunk_units_;
  GlProgram* program_ = nullptr;
};

}  // namespace sluice
