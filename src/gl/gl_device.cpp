#include "src/gl/gl_device.h"

#include <algorithm>
#include <array>
#include <utility>

#include "src/base/error.h"
#include "src/device/boxes_together.h"
#include "src/gl/box_buffer.h"
#include "src/gl/deep_boxes.h"
#include "src/gl/filter_check.h"
#include "src/gl/shaders/shading.h"

namespace sluice {
namespace {

// Boxes a draw call: bounded by the smallest legal buffer texture (65536 texels).
constexpr size_t kBoxesPerDraw = 65536 / kTexelsPerBox;
// Texture units; 1, those from 3 to 5, 7 and 8 belong to LookTextures, and those from 9 on to boxes
// that join another one (joined_boxes.cpp).
constexpr GLenum kChunkUnit = 0, kKeptUnit = 6;

constexpr Vec3d kOne{1, 1, 1};

bool haveOneScale(const BoxDraw& a, const BoxDraw& b) {
  return a.texels.indexScale() == b.texels.indexScale();
}
bool haveOneProgram(const BoxDraw& a, const BoxDraw& b) {
  return haveOneScale(a, b) && a.beside.has_value() == b.beside.has_value() && a.fade == b.fade;
}

// The boxes from the first on that are `alike` it.
template <class Alike>
std::span<const BoxDraw> firstAlike(std::span<const BoxDraw> boxes, const Alike& alike) {
  size_t count = 1;
  while (count < boxes.size() && alike(boxes[0], boxes[count])) ++count;
  return boxes.first(count);
}

std::unique_ptr<GlContext> currentOf(std::unique_ptr<GlContext> context) {
  context->makeCurrent();
  return context;
}

}  // namespace

GlDevice::GlDevice(std::unique_ptr<GlContext> context, std::optional<bool> fetches)
    : context_(currentOf(std::move(context))),
      gl_(context_->functions()),
      pool_(gl_),
      look_(gl_),
      occlusion_(gl_),
      blended_(gl_, context_->limits().max_texture_units),
      target_(gl_, context_->has("GL_MESA_pack_invert")),
      screen_(gl_) {
  gl_.GenVertexArrays(1, &vertex_array_);
  gl_.BindVertexArray(vertex_array_);
  gl_.GenBuffers(1, &index_buffer_);
  gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, index_buffer_);
  gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, kCubeTriangles.size(), kCubeTriangles.data(),
                 GL_STATIC_DRAW);
  gl_.GenBuffers(1, &box_buffer_);
  gl_.GenTextures(1, &box_texture_);
  // Software is known to be exact (GALLIVM_PERF, see context.h); to look takes it 30 ms.
  fetches_ = fetches.value_or(!context_->isSoftware() && !filtersExactly(gl_));
}

GlDevice::~GlDevice() {
  context_->makeCurrent();
  for (auto& [id, chunk] : resident_) gl_.DeleteTextures(1, &chunk.texture);
  gl_.DeleteTextures(1, &box_texture_);
  gl_.DeleteBuffers(1, &box_buffer_);
  gl_.DeleteBuffers(1, &index_buffer_);
  gl_.DeleteVertexArrays(1, &vertex_array_);
}

DeviceLimits GlDevice::limits() const {
  const GlLimits& limits = context_->limits();
  return {std::min(limits.max_texture_size, limits.max_viewport_size),
          context_->isSoftware() ? TexelPlace::kInMemory : TexelPlace::kOnDevice};
}

void GlDevice::makeResident(uint64_t id, ChunkTexelsPtr texels) {
  context_->makeCurrent();
  gl_.ActiveTexture(GL_TEXTURE0 + kChunkUnit);
  const TexturePool::Format format{texels->type, texels->has_spread};
  const Resident resident{pool_.take(texels->storage_vox, format, texels->span()),
                          texels->storage_vox, format};
  const bool fresh = resident_.emplace(id, resident).second;
  SLUICE_CHECK(fresh);
}

void GlDevice::evict(uint64_t id) {
  context_->makeCurrent();
  const auto found = resident_.find(id);
  SLUICE_CHECK(found != resident_.end());
  pool_.giveBack(found->second.texture, found->second.storage_vox, found->second.format);
  resident_.erase(found);
}

GlProgram& GlDevice::programFor(const ShaderVariant& variant) {
  auto& program = programs_[variant];
  if (!program)
    program = std::make_unique<GlProgram>(gl_, vertexShader(variant), fragmentShader(variant));
  program->use();
  return *program;
}

void GlDevice::setBlending(Combining combining) {
  if (combining == Combining::kAttenuated) {  // by the shader, see drawOverKept()
    gl_.Disable(GL_BLEND);
    return;
  }
  gl_.Enable(GL_BLEND);
  gl_.BlendEquation(combining == Combining::kGreatest ? GL_MAX
                    : combining == Combining::kLeast  ? GL_MIN
                                                      : GL_FUNC_ADD);
  // `under` for premultiplied colour drawn front to back.
  gl_.BlendFunc(combining == Combining::kBlend ? GL_ONE_MINUS_DST_ALPHA : GL_ONE, GL_ONE);
}

void GlDevice::setFrameView(GlProgram& program) {
  program.set("boxes", static_cast<int>(kBoxUnit));
  setView(setup_, frame_rows_, program);
  if (setup_.jitter > 0) look_.setJitter(setup_, program);
}

void GlDevice::bindTarget() {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_.framebuffer());
  // The viewport spans the whole picture, of which the target has some rows.
  gl_.Viewport(0, -frame_rows_.lo, setup_.size.width, setup_.size.height);
  const std::array<GLenum, 2> outputs = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  gl_.DrawBuffers(variant_.with_depth || variant_.counts_taken ? 2 : 1, outputs.data());
  // The attenuated mode reads the second texture, which must not be a target at the same time.
  target_.attachSecond(variant_.combining != Combining::kAttenuated);
  setBlending(traitsOf(setup_.mode).combining);
  gl_.Enable(GL_CULL_FACE);
  // Back faces, so that a box around the eye is drawn too, and each pixel of a box once.
  gl_.CullFace(GL_FRONT);
  gl_.FrontFace(isMirrored(setup_) ? GL_CW : GL_CCW);
  // Boxes lie at half depth, marked pixels at none; see OcclusionPasses.
  gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, marked_);
  if (marked_ != 0)
    gl_.Enable(GL_DEPTH_TEST);
  else
    gl_.Disable(GL_DEPTH_TEST);
  gl_.DepthFunc(GL_LESS);
  gl_.DepthMask(GL_FALSE);
}

std::vector<float> GlDevice::leastOpacity(const MapGrid& grid) {
  context_->makeCurrent();
  SLUICE_CHECK(traitsOf(setup_.mode).hides);
  SLUICE_CHECK(!rows_);  // opacity maps belong to whole pictures
  std::vector<float> least = occlusion_.leastOpacity(target_.color(), setup_.size, grid);
  bindTarget();
  return least;
}

void GlDevice::stopOpaque() {
  context_->makeCurrent();
  SLUICE_CHECK(traitsOf(setup_.mode).hides);
  SLUICE_CHECK(!rows_);
  marked_ = occlusion_.markOpaque(target_.color(), setup_.size, setup_.opacity_threshold);
  bindTarget();
}

void GlDevice::beginFrame(const FrameSetup& setup, const StopToken& stop) {
  SLUICE_CHECK_LE(setup.clip_planes.size(), kMostClipPlanes);
  context_->makeCurrent();
  setup_ = setup;
  stop_ = stop;
  pieces_.emplace(setup_);
  const ModeTraits& traits = traitsOf(setup.mode);
  variant_ = frameVariant(setup, fetches_);
  requirePictureSize(setup.size, limits());
  frame_rows_ = rows_.value_or(PictureRows{0, setup.size.height});
  frame_rows_.hi = std::min(frame_rows_.hi, setup.size.height);
  SLUICE_CHECK(!rows_ || !setup.is_part);
  target_.resize({setup.size.width, frame_rows_.hi - frame_rows_.lo});
  marked_ = 0;
  bindTarget();
  const float start = traits.first_value;
  gl_.ClearColor(start, start, start, start);
  gl_.Clear(GL_COLOR_BUFFER_BIT);
  told_.clear();
  if (setup_.others.empty())
    frameProgram({}, false);
  else
    blended_.begin(setup_, fetches_);
}

void GlDevice::setFrame(const ShaderVariant& variant, GlProgram& program) {
  setFrameView(program);
  program.set("chunk", static_cast<int>(kChunkUnit));
  look_.setLookUp(setup_, variant_, program);
  const ModeTraits& traits = traitsOf(setup_.mode);
  if (traits.has_colors) setShading(setup_, variant, program);
  if (variant_.light_volume) look_.setLight(setup_, program);
  if (traits.combining == Combining::kAttenuated) program.set("kept", static_cast<int>(kKeptUnit));
  setWindow(setup_, program);
}

GlProgram& GlDevice::frameProgram(const BoxDraw& box, bool has_spread) {
  SLUICE_CHECK(!has_spread || drawsSpreads(setup_));
  const Vec3d scale = box.texels.indexScale();
  const ShaderVariant variant = besideVariant(setup_, boxVariant(variant_, scale, has_spread), box);
  GlProgram& program = programFor(variant);
  if (told_.insert(variant).second) {
    setFrame(variant, program);
    look_.setSecondNumber(setup_, variant, program);
    if (variant.integrates) look_.setSums(setup_, program);
  }
  if (variant.scaled) program.set("texel_scale", scale);
  setFade(box, program);
  return program;
}

void GlDevice::drawBoxes(std::span<const BoxDraw> boxes, size_t group) {
  gl_.ActiveTexture(GL_TEXTURE0 + kBoxUnit);
  gl_.BindTexture(GL_TEXTURE_BUFFER, box_texture_);
  const size_t most = kBoxesPerDraw / group * group;
  for (size_t from = 0; from < boxes.size(); from += most) {
    const auto part = boxes.subspan(from, std::min(most, boxes.size() - from));
    const std::vector<float> texels = boxTexels(setup_, part);
    gl_.BindBuffer(GL_TEXTURE_BUFFER, box_buffer_);
    gl_.BufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(texels.size() * sizeof(float)),
                   texels.data(), GL_STREAM_DRAW);
    gl_.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, box_buffer_);
    gl_.DrawElementsInstanced(GL_TRIANGLES, static_cast<GLsizei>(kCubeTriangles.size()),
                              GL_UNSIGNED_BYTE, nullptr, static_cast<GLsizei>(part.size() / group));
  }
}

void GlDevice::drawOverKept(std::span<const BoxDraw> boxes, int row_lo, int row_hi) {
  for (size_t i = 0; i < boxes.size(); ++i) {
    const PictureRows rows = rowsOf(setup_, boxes[i].cells);
    const int lo = std::max(rows.lo, row_lo), hi = std::min(rows.hi, row_hi);
    if (lo >= hi) continue;
    gl_.ActiveTexture(GL_TEXTURE0 + kKeptUnit);
    // A box reads what lies before it, so boxes are drawn one by one, each with a copy of its rows.
    target_.keepRows(lo - frame_rows_.lo, hi - frame_rows_.lo);
    drawBoxes(boxes.subspan(i, 1));
  }
}

void GlDevice::draw(std::span<const BoxDraw> given) {
  context_->makeCurrent();
  const std::vector<BoxDraw> parts = cutDeepBoxes(
      setup_, given, mostSlices(variant_, std::max(mostTogether(given), 1 + setup_.others.size())));
  std::span<const BoxDraw> boxes = parts;
  if (!setup_.others.empty()) return drawBlended(boxes);
  while (!boxes.empty()) {
    if (boxes.size() > 1 && boxes[1].joins) {
      const size_t count = countTogether(boxes);
      drawJoined(boxes.first(count));
      boxes = boxes.subspan(count);
      continue;
    }
    auto of_chunk = firstAlike(boxes, [](const BoxDraw& a, const BoxDraw& b) {  //
      return a.chunk == b.chunk;
    });
    // The last one is drawn with those that join it.
    if (of_chunk.size() < boxes.size() && boxes[of_chunk.size()].joins)
      of_chunk = of_chunk.first(of_chunk.size() - 1);
    boxes = boxes.subspan(of_chunk.size());
    ++binds_;
    while (!of_chunk.empty()) {
      const auto part = firstAlike(of_chunk, haveOneProgram);
      drawFromChunk(part);
      of_chunk = of_chunk.subspan(part.size());
    }
  }
}

void GlDevice::drawFromChunk(std::span<const BoxDraw> boxes) {
  const auto found = resident_.find(boxes.front().chunk);
  SLUICE_CHECK(found != resident_.end());
  const BoxDraw& first = boxes.front();
  if (first.beside && besideVariant(setup_, variant_, first).surfaces == 0) return;
  frameProgram(first, found->second.format.has_spread)
      .set("chunk_texel_size", kOne / toDouble(found->second.storage_vox));
  gl_.ActiveTexture(GL_TEXTURE0 + kChunkUnit);
  gl_.BindTexture(GL_TEXTURE_3D, found->second.texture);
  drawPieces(boxes, [&](const DrawingPiece& piece) {
    const auto of_piece = boxes.subspan(piece.first, piece.count);
    if (variant_.combining == Combining::kAttenuated)
      drawOverKept(of_piece, piece.row_lo, piece.row_hi);
    else
      drawBoxes(of_piece);
  });
}

void GlDevice::drawPieces(std::span<const BoxDraw> boxes,
                          const std::function<void(const DrawingPiece&)>& draw) {
  for (DrawingPiece piece : pieces_->cut(boxes)) {
    // A stop takes effect only if the driver is not ahead by seconds of work.
    if (piece.waits) gl_.Finish();
    stop_.throwIfStopped();
    piece.row_lo = std::max(piece.row_lo, frame_rows_.lo);
    piece.row_hi = std::min(piece.row_hi, frame_rows_.hi);
    if (piece.row_lo >= piece.row_hi) continue;
    const bool is_band = piece.row_lo > frame_rows_.lo || piece.row_hi < frame_rows_.hi;
    if (is_band) {
      gl_.Enable(GL_SCISSOR_TEST);
      gl_.Scissor(0, piece.row_lo - frame_rows_.lo, setup_.size.width, piece.row_hi - piece.row_lo);
    }
    draw(piece);
    if (is_band) gl_.Disable(GL_SCISSOR_TEST);
  }
}

uint64_t GlDevice::countSamples(std::span<const BoxDraw> boxes) {
  context_->makeCurrent();
  // The depth attachment is free between frames: it takes the counts, the picture stays.
  ShaderVariant counting;
  counting.counts = true;
  counting.clip_planes = variant_.clip_planes;
  counting.planes = variant_.planes;
  counting.jitters = variant_.jitters;
  gl_.BindFramebuffer(GL_FRAMEBUFFER, target_.framebuffer());
  target_.attachSecond(true);
  const GLenum output = GL_COLOR_ATTACHMENT1;
  gl_.DrawBuffers(1, &output);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.ClearColor(0, 0, 0, 0);
  gl_.Clear(GL_COLOR_BUFFER_BIT);
  setBlending(Combining::kSum);
  while (!boxes.empty()) {
    const size_t count =
        firstAlike(boxes.first(std::min(kBoxesPerDraw, boxes.size())), haveOneScale).size();
    const Vec3d scale = boxes[0].texels.indexScale();
    counting.scaled = scale != kOne;
    GlProgram& program = programFor(counting);
    setFrameView(program);
    if (counting.scaled) program.set("texel_scale", scale);
    drawBoxes(boxes.first(count));
    gl_.Finish();  // else software GL keeps its data of all of them
    boxes = boxes.subspan(count);
  }
  return sumOfCounts();
}

uint64_t GlDevice::takenSamples() {
  context_->makeCurrent();
  SLUICE_CHECK(variant_.counts_taken);
  return sumOfCounts();
}

uint64_t GlDevice::sumOfCounts() {
  double sum = 0;
  std::vector<float> counts;
  target_.read(GL_COLOR_ATTACHMENT1, counts);
  for (size_t i = 0; i < counts.size(); i += 4) sum += counts[i];
  return static_cast<uint64_t>(sum);
}

Picture GlDevice::endFrame() {
  context_->makeCurrent();
  Picture picture = std::exchange(spare_, {});
  picture.width = target_.size().width;
  picture.height = target_.size().height;
  picture.depth.clear();
  const auto background = std::exchange(keeps_, std::nullopt);
  if (background && traitsOf(setup_.mode).has_colors && !setup_.with_depth && !setup_.is_part) {
    picture.rgba.clear();
    kept_ = screen_.make(target_.color(), target_.size(), *background);
    return picture;
  }
  target_.read(GL_COLOR_ATTACHMENT0, picture.rgba);
  if (!traitsOf(setup_.mode).has_colors) {
    if (setup_.is_part)
      scaleValues(setup_, valueScale(setup_.type), picture.rgba);
    else
      resolveMode(setup_, valueScale(setup_.type), picture.rgba);
  }
  if (variant_.with_depth) {
    target_.readDepth(picture.depth);
  }
  return picture;
}

}  // namespace sluice
