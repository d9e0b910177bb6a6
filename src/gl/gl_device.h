// GlDevice: the GL implementation of Device. It draws the back faces of each box once and walks the
// view's slices through the box in the fragment shader. The samples equal those of slice polygons,
// in the same places and order, but a pixel's sum is blended into the target once a box and not
// once a slice, on which software GL spends most of its time otherwise.
//
// Used by one thread, the one that made the context. It makes its context current in every call, so
// that several devices take turns on that thread.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "src/device/device.h"
#include "src/device/pictures/picture_rows.h"
#include "src/device/pictures/screen_picture.h"
#include "src/gl/blended_drawing.h"
#include "src/gl/contexts/context.h"
#include "src/gl/drawing_pieces.h"
#include "src/gl/look_textures.h"
#include "src/gl/occlusion_passes.h"
#include "src/gl/render_target.h"
#include "src/gl/screen_textures.h"
#include "src/gl/shaders/gl_program.h"
#include "src/gl/shaders/shaders.h"
#include "src/gl/texture_pool.h"

namespace sluice {

class GlDevice : public Device, public DrawsForScreens, public DrawsRows {
 public:
  // `fetches`: ShaderVariant's; unset: if the driver's hardware needs it.
  explicit GlDevice(std::unique_ptr<GlContext> context, std::optional<bool> fetches = {});
  ~GlDevice() override;

  DeviceLimits limits() const override;
  const char* backend() const override { return context_->backend().data(); }
  const char* renderer() const override { return context_->renderer().c_str(); }
  void makeResident(uint64_t id, ChunkTexelsPtr texels) override;
  void evict(uint64_t id) override;
  uint64_t uploadedBytes() const override { return pool_.uploadedBytes(); }
  uint64_t binds() const override { return binds_; }
  void beginFrame(const FrameSetup& setup, const StopToken& stop = {}) override;
  void draw(std::span<const BoxDraw> boxes) override;
  std::vector<float> leastOpacity(const MapGrid& grid) override;
  void stopOpaque() override;
  uint64_t countSamples(std::span<const BoxDraw> boxes) override;
  uint64_t takenSamples() override;
  Picture endFrame() override;
  void cancelFrame() override {}
  void keepNext(std::optional<std::array<float, 3>> background) override { keeps_ = background; }
  std::optional<ScreenPicture> takeKept() override { return std::exchange(kept_, std::nullopt); }
  void drawRows(std::optional<PictureRows> rows) override { rows_ = rows; }
  std::optional<PictureRows> rows() const override { return rows_; }

 private:
  struct Resident {
    GLuint texture;
    Vec3i storage_vox;
    TexturePool::Format format;
  };

  GlProgram& programFor(const ShaderVariant& variant);
  // The frame's program for boxes like this one (haveOneProgram()) of a chunk with spreads or
  // without: told of the frame, in use.
  GlProgram& frameProgram(const BoxDraw& box, bool has_spread);
  // Tells a program of the frame all that no box changes.
  void setFrame(const ShaderVariant& variant, GlProgram& program);
  void setFrameView(GlProgram& program);
  void setBlending(Combining combining);
  // Restores the state of beginFrame() after another pass.
  void bindTarget();
  // Draws boxes of one chunk and one scale, in pieces between which it checks whether to stop.
  void drawFromChunk(std::span<const BoxDraw> boxes);
  // Draws a box together with those that join it.
  void drawJoined(std::span<const BoxDraw> boxes);
  // Draws the boxes of a frame of several channels.
  void drawBlended(std::span<const BoxDraw> boxes);
  void drawPieces(std::span<const BoxDraw> boxes,
                  const std::function<void(const DrawingPiece&)>& draw);
  // Draws the boxes, or the first of each `group` of so many, which the program knows how to read.
  void drawBoxes(std::span<const BoxDraw> boxes, size_t group = 1);
  // The same box by box, with the target's rows [row_lo, row_hi) of each as they were before it.
  void drawOverKept(std::span<const BoxDraw> boxes, int row_lo, int row_hi);
  // Adds up the counts in the second attachment.
  uint64_t sumOfCounts();

  std::unique_ptr<GlContext> context_;
  const GlFunctions& gl_;
  TexturePool pool_;
  LookTextures look_;
  OcclusionPasses occlusion_;
  BlendedDrawing blended_;
  RenderTarget target_;
  ScreenTextures screen_;
  std::optional<std::array<float, 3>> keeps_;  // the next frame, over this background
  std::optional<ScreenPicture> kept_;
  std::unordered_map<uint64_t, Resident> resident_;
  std::map<ShaderVariant, std::unique_ptr<GlProgram>> programs_;
  FrameSetup setup_;
  std::optional<PictureRows> rows_;  // rows of the next frame; none: all
  PictureRows frame_rows_;           // rows of this frame that the target has
  StopToken stop_;
  std::optional<DrawingPieces> pieces_;  // for the current frame
  bool fetches_ = false;                 // see ShaderVariant
  ShaderVariant variant_;
  std::set<ShaderVariant> told_;  // programs that know of this frame
  GLuint vertex_array_ = 0, index_buffer_ = 0, box_buffer_ = 0, box_texture_ = 0;
  uint64_t binds_ = 0;
  GLuint marked_ = 0;  // depth buffer with the opaque pixels; 0: none are marked in this frame
};

}  // namespace sluice
