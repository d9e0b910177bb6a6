#include "src/gl/blended_drawing.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/device/boxes_together.h"
#include "src/gl/shaders/shading.h"

namespace sluice {

BlendedBlocks takeBlocks(std::span<const BoxDraw>& boxes, size_t channels) {
  BlendedBlocks blocks;
  blocks.chunks.resize(channels);
  while (!boxes.empty()) {
    const size_t count = countTogether(boxes);
    const std::span<const BoxDraw> of_block = boxes.first(count);
    const Vec3d scale = of_block.front().texels.indexScale();
    // One draw call binds one chunk a channel and has one scale, so a block with another one begins
    // the next call.
    const bool fits = std::ranges::all_of(of_block, [&](const BoxDraw& box) {
      SLUICE_CHECK(box.texels.indexScale() == scale);
      return blocks.chunks[box.channel].value_or(box.chunk) == box.chunk &&
             (blocks.hulls.empty() || blocks.hulls.front().texels.indexScale() == scale);
    });
    if (!fits) break;
    // The hull is what the rasteriser covers: a pixel that any channel's box covers is drawn once,
    // with all channels.
    BoxDraw hull = of_block.front();
    for (const BoxDraw& box : of_block) hull.cells = unite(hull.cells, box.cells);
    // A channel without a box in this block has an empty one, so that each block has as many.
    BoxDraw empty = hull;
    empty.cells.hi = empty.cells.lo;
    const size_t first = blocks.boxes.size();
    blocks.boxes.resize(first + channels, empty);
    for (const BoxDraw& box : of_block) {
      blocks.boxes[first + box.channel] = box;
      blocks.chunks[box.channel] = box.chunk;
    }
    blocks.hulls.push_back(hull);
    boxes = boxes.subspan(count);
  }
  return blocks;
}

std::vector<BoxDraw> inGroups(const BlendedBlocks& blocks, size_t first, size_t count) {
  const size_t channels = blocks.chunks.size();
  std::vector<BoxDraw> groups;
  for (size_t i = first; i < first + count; ++i) {
    groups.push_back(blocks.hulls[i]);
    for (size_t c = 0; c < channels; ++c) groups.push_back(blocks.boxes[i * channels + c]);
  }
  return groups;
}

void BlendedDrawing::begin(const FrameSetup& setup, bool fetches) {
  channels_ = {&setup};
  for (const FrameSetup& other : setup.others) channels_.push_back(&other);
  variants_.clear();
  for (const FrameSetup* channel : channels_) variants_.push_back(frameVariant(*channel, fetches));
  told_.clear();

  // Units that the frame's other textures leave.
  GLenum next = 0;
  const auto takeUnit = [&next] {
    while (next == kBoxUnit || next == kNoiseUnit) ++next;
    return next++;
  };
  chunk_units_.clear();
  look_units_.clear();
  for (size_t c = 0; c < channels_.size(); ++c) {
    chunk_units_.push_back(takeUnit());
    LookUnits units;
    units.look_up = units.factors = units.expected = takeUnit();
    if (variants_[c].factor_table) units.factors = takeUnit();
    if (channels_[c]->look_up->expected != nullptr) units.expected = takeUnit();
    look_units_.push_back(units);
  }
  if (static_cast<int>(std::max(next, kNoiseUnit + 1)) > texture_units_)
    failRequest(
        "--combine blend: {} channels need {} textures at once, and the GL driver has {}; give "
        "--device cpu, or fewer channels",
        channels_.size(), std::max(next, kNoiseUnit + 1), texture_units_);
  while (looks_.size() < channels_.size()) looks_.push_back(std::make_unique<LookTextures>(gl_));
}

void BlendedDrawing::use(Vec3d scale, const std::vector<std::optional<bool>>& has_spread,
                         const std::function<void(GlProgram&)>& tell) {
  // A channel without a chunk takes after the others, so that few programs serve all blocks.
  const bool have_spreads = std::ranges::count(has_spread, std::optional(true)) > 0;
  BlendedVariant variant;
  for (size_t c = 0; c < channels_.size(); ++c) {
    const bool draws_spreads = drawsSpreads(*channels_[c]);
    SLUICE_CHECK(draws_spreads || !has_spread[c].value_or(false));
    variant.channels.push_back(
        boxVariant(variants_[c], scale, has_spread[c].value_or(have_spreads && draws_spreads)));
  }
  variant.view = viewVariant(variant.channels.front());
  auto& program = programs_[variant];
  if (!program)
    program = std::make_unique<GlProgram>(gl_, blendedVertexShader(variant),
                                          blendedFragmentShader(variant));
  program_ = program.get();
  program->use();
  // Uniforms are a program's own and stay, so each program is told once a frame.
  const bool is_new = told_.insert(variant).second;
  for (size_t c = 0; c < channels_.size(); ++c) {
    const FrameSetup& channel = *channels_[c];
    program->ofChannel(c);
    if (is_new) {
      program->set("chunk", static_cast<int>(chunk_units_[c]));
      looks_[c]->setLookUp(channel, variant.channels[c], *program, look_units_[c]);
      looks_[c]->setSecondNumber(channel, variant.channels[c], *program, look_units_[c]);
      setShading(channel, variant.channels[c], *program);
    }
    if (variant.channels[c].scaled) program->set("texel_scale", scale);
  }
  program->ofAll();
  if (is_new) tell(*program);
}

void BlendedDrawing::bindChunk(size_t channel, GLuint texture, Vec3i storage_vox) {
  gl_.ActiveTexture(GL_TEXTURE0 + chunk_units_[channel]);
  gl_.BindTexture(GL_TEXTURE_3D, texture);
  const Vec3d size = toDouble(storage_vox);
  program_->ofChannel(channel);
  program_->set("chunk_texel_size", Vec3d{1 / size.x, 1 / size.y, 1 / size.z});
  program_->ofAll();
}

}  // namespace sluice
