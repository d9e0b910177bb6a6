#include "src/gl/render_target.h"

#include <limits>
#include <utility>

#include "src/base/error.h"
#include "src/base/memory/large_pages.h"

namespace sluice {
namespace {

// GL_PACK_INVERT_MESA of GL_MESA_pack_invert: rows are read downwards.
constexpr GLenum kPackInvert = 0x8758;

}  // namespace

RenderTarget::~RenderTarget() {
  gl_.DeleteFramebuffers(1, &framebuffer_);
  gl_.DeleteTextures(1, &color_);
  gl_.DeleteTextures(1, &second_);
  gl_.DeleteFramebuffers(1, &turned_framebuffer_);
  gl_.DeleteTextures(1, &turned_);
}

void RenderTarget::resize(PictureSize size) {
  if (size == size_) return;
  size_ = {0, 0};  // until the driver has agreed to all of it
  // Errors from before are not of this allocation.
  while (gl_.GetError() != GL_NO_ERROR) {
  }
  if (framebuffer_ == 0) {
    gl_.GenFramebuffers(1, &framebuffer_);
    gl_.GenTextures(1, &color_);
    gl_.GenTextures(1, &second_);
  }
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  for (const auto& [texture, attachment] :
       {std::pair(color_, GL_COLOR_ATTACHMENT0), std::pair(second_, GL_COLOR_ATTACHMENT1)}) {
    makeFloats(texture, size);
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, static_cast<GLenum>(attachment), GL_TEXTURE_2D,
                             texture, 0);
  }
  // A driver without memory for it may say so by either.
  if (gl_.GetError() != GL_NO_ERROR ||
      gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    failSystem("the GL driver cannot draw a float picture of {} x {} pixels", size.width,
               size.height);
  size_ = size;
}

void RenderTarget::makeFloats(GLuint texture, PictureSize size) const {
  gl_.BindTexture(GL_TEXTURE_2D, texture);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, size.width, size.height, 0, GL_RGBA, GL_FLOAT,
                 nullptr);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
}

void RenderTarget::attachSecond(bool is_attached) const {
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D,
                           is_attached ? second_ : 0, 0);
}

void RenderTarget::keepRows(int lo, int hi) const {
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl_.BindTexture(GL_TEXTURE_2D, second_);
  gl_.CopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, lo, 0, lo, size_.width, hi - lo);
}

void RenderTarget::read(GLenum attachment, std::vector<float>& rgba) {
  const auto width = static_cast<size_t>(size_.width);
  const auto height = static_cast<size_t>(size_.height);
  const size_t count = width * height * 4;
  if (rgba.capacity() < count) {
    rgba.clear();
    reserveLarge(rgba, count);
  }
  rgba.resize(count);
  // GL's rows go upwards.
  gl_.ReadBuffer(attachment);
  if (inverts_)
    gl_.PixelStorei(kPackInvert, GL_TRUE);
  else
    turn();
  gl_.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl_.ReadPixels(0, 0, size_.width, size_.height, GL_RGBA, GL_FLOAT, rgba.data());
  if (inverts_)
    gl_.PixelStorei(kPackInvert, GL_FALSE);
  else
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
}

void RenderTarget::readDepth(std::vector<float>& depth) {
  std::vector<float> sums;
  read(GL_COLOR_ATTACHMENT1, sums);
  depth.resize(sums.size() / 4);
  for (size_t i = 0; i < depth.size(); ++i) {
    const float opacity = sums[4 * i + 3];
    depth[i] = opacity > 0 ? sums[4 * i] / opacity : std::numeric_limits<float>::infinity();
  }
}

void RenderTarget::turn() {
  if (turned_framebuffer_ == 0) {
    gl_.GenFramebuffers(1, &turned_framebuffer_);
    gl_.GenTextures(1, &turned_);
  }
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, turned_framebuffer_);
  if (turned_size_.width != size_.width || turned_size_.height != size_.height) {
    makeFloats(turned_, size_);
    gl_.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, turned_, 0);
    turned_size_ = size_;
  }
  // Turned on the device, since turning rows on the processor copies the picture once more.
  gl_.BlitFramebuffer(0, 0, size_.width, size_.height, 0, size_.height, size_.width, 0,
                      GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, turned_framebuffer_);
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
}

}  // namespace sluice
