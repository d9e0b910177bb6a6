// How the OpenGL device draws boxes together (BoxDraw::joins): the shader walks the slices of one
// and reads the texels of all.
#include "src/base/error.h"
#include "src/gl/gl_device.h"
#include "src/gl/shaders/shading.h"

namespace sluice {
namespace {

// Texture units: the box's own chunk, and the first of those of the boxes that join it. GL 3.3 has
// 16 units, which leaves one for each face of a block.
constexpr GLenum kOwnUnit = 0, kJoinedUnit = 9;

}  // namespace

void GlDevice::drawJoined(std::span<const BoxDraw> boxes) {
  std::vector<const Resident*> chunks;
  std::vector<bool> have_spreads;
  for (const BoxDraw& box : boxes) {
    const auto found = resident_.find(box.chunk);
    SLUICE_CHECK(found != resident_.end());
    chunks.push_back(&found->second);
    have_spreads.push_back(found->second.format.has_spread);
    SLUICE_CHECK(!have_spreads.back() || drawsSpreads(setup_));
    ++binds_;
  }
  const BoxDraw& box = boxes.front();
  const Vec3d scale = box.texels.indexScale();
  const ShaderVariant of_box =
      besideVariant(setup_, boxVariant(variant_, scale, have_spreads[0]), box);
  have_spreads.erase(have_spreads.begin());
  const ShaderVariant variant = withJoined(of_box, have_spreads);
  GlProgram& program = programFor(variant);
  const auto number = [](size_t i) { return static_cast<int>(i) - 1; };
  if (told_.insert(variant).second) {
    setFrame(variant, program);
    look_.setSecondNumber(setup_, variant, program);
    for (size_t i = 1; i < boxes.size(); ++i) {
      const ShaderVariant joined = joinedVariant(variant, number(i));
      program.ofChannel(i - 1);
      program.set("chunk", static_cast<int>(kJoinedUnit) + number(i));
      look_.setLookUp(setup_, joined, program);
      look_.setSecondNumber(setup_, joined, program);
      setShading(setup_, joined, program);
    }
    program.ofAll();
  }
  if (variant.scaled) program.set("texel_scale", scale);
  for (size_t i = 0; i < boxes.size(); ++i) {
    if (i > 0) {
      program.ofChannel(i - 1);
      program.set("texel_scale", boxes[i].texels.indexScale());
    }
    program.set("chunk_texel_size", Vec3d{1, 1, 1} / toDouble(chunks[i]->storage_vox));
    setFade(boxes[i], program);
    gl_.ActiveTexture(GL_TEXTURE0 + (i == 0 ? kOwnUnit : kJoinedUnit + static_cast<GLenum>(i) - 1));
    gl_.BindTexture(GL_TEXTURE_3D, chunks[i]->texture);
  }
  program.ofAll();
  drawPieces(boxes.first(1), [&](const DrawingPiece&) { drawBoxes(boxes, boxes.size()); });
}

void GlDevice::drawBlended(std::span<const BoxDraw> boxes) {
  const size_t channels = setup_.others.size() + 1;
  while (!boxes.empty()) {
    const BlendedBlocks blocks = takeBlocks(boxes, channels);
    std::vector<const Resident*> chunks(channels, nullptr);
    std::vector<std::optional<bool>> has_spread(channels);
    for (size_t c = 0; c < channels; ++c) {
      if (!blocks.chunks[c]) continue;
      const auto found = resident_.find(*blocks.chunks[c]);
      SLUICE_CHECK(found != resident_.end());
      chunks[c] = &found->second;
      has_spread[c] = chunks[c]->format.has_spread;
    }
    blended_.use(blocks.hulls.front().texels.indexScale(), has_spread,
                 [this](GlProgram& program) { setFrameView(program); });
    for (size_t c = 0; c < channels; ++c) {
      if (chunks[c] == nullptr) continue;
      blended_.bindChunk(c, chunks[c]->texture, chunks[c]->storage_vox);
      ++binds_;
    }
    drawPieces(blocks.hulls, [&](const DrawingPiece& piece) {
      drawBoxes(inGroups(blocks, piece.first, piece.count), channels + 1);
    });
  }
}

}  // namespace sluice
