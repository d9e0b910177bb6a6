#include "src/gl/blended_drawing.h"

#include <algorithm>

#include "src/base/error.h"
#include "src/gl/shaders/shading.h"

namespace sluice {

BlendedBlocks takeBlocks(std::span<const BoxDraw>& boxes, size_t channels) {
  BlendedBlocks blocks;
  blocks.chunks.resize(channels);
  while (!boxes.empty()) {
    size_t count = 1;
    while (count < boxes.size() && boxes[count].joins) ++count;
    const std::span<const BoxDraw> of_block = boxes.first(count);
    const bool fits = std::ranges::all_of(of_block, [&](const BoxDraw& box) {
      return blocks.chunks[box.channel].value_or(box.chunk) == box.chunk;
    });
    if (!fits) break;
    BoxDraw hull = of_block.front();
    for (const BoxDraw& box : of_block) hull.cells = unite(hull.cells, box.cells);
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

GlProgram& BlendedDrawing::begin(const FrameSetup& setup, bool fetches) {
  std::vector<const FrameSetup*> channels{&setup};
  for (const FrameSetup& other : setup.others) channels.push_back(&other);
  BlendedVariant variant;
  for (const FrameSetup* channel : channels)
    variant.channels.push_back(frameVariant(*channel, fetches));
  variant.view = viewVariant(variant.channels.front());

  // Units that the frame's other textures leave.
  GLenum next = 0;
  const auto takeUnit = [&next] {
    while (next == kBoxUnit || next == kNoiseUnit) ++next;
    return next++;
  };
  chunk_units_.clear();
  std::vector<LookUnits> units;
  for (const ShaderVariant& channel : variant.channels) {
    chunk_units_.push_back(takeUnit());
    const GLenum look_up = takeUnit();
    units.push_back({look_up, channel.factor_table ? takeUnit() : look_up});
  }
  if (static_cast<int>(std::max(next, kNoiseUnit + 1)) > texture_units_)
    failRequest(
        "--combine blend: {} channels need {} textures at once, and the GL driver has {}; give "
        "--device cpu, or fewer channels",
        channels.size(), std::max(next, kNoiseUnit + 1), texture_units_);

  auto& program = programs_[variant];
  if (!program)
    program = std::make_unique<GlProgram>(gl_, blendedVertexShader(variant),
                                          blendedFragmentShader(variant));
  program_ = program.get();
  program->use();
  while (looks_.size() < channels.size()) looks_.push_back(std::make_unique<LookTextures>(gl_));
  for (size_t c = 0; c < channels.size(); ++c) {
    const FrameSetup& channel = *channels[c];
    program->ofChannel(c);
    program->set("chunk", static_cast<int>(chunk_units_[c]));
    looks_[c]->setLookUp(channel, variant.channels[c], *program, units[c]);
    setShading(channel, variant.channels[c], *program);
  }
  program->ofAll();
  return *program;
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
