// RenderTarget: a framebuffer of two float pictures: colour, and a second one for depth, for counts
// or for what colour held before.
// Its context must be current in every call.
#pragma once

#include <vector>

#include "src/device/device.h"
#include "src/gl/contexts/gl_functions.h"

namespace sluice {

class RenderTarget {
 public:
  // `inverts`: the driver reads rows downwards (GL_MESA_pack_invert).
  RenderTarget(const GlFunctions& gl, bool inverts) : gl_(gl), inverts_(inverts) {}
  ~RenderTarget();
  RenderTarget(const RenderTarget&) = delete;
  RenderTarget& operator=(const RenderTarget&) = delete;

  // Makes both pictures again if the size differs. Throws Error if the driver refuses.
  void resize(PictureSize size);
  PictureSize size() const { return size_; }
  GLuint framebuffer() const { return framebuffer_; }
  GLuint color() const { return color_; }

  // Whether drawing may write the second picture, or shaders may read it. Requires: the framebuffer
  // is bound.
  void attachSecond(bool is_attached) const;
  // Copies these rows of the colour picture, counted from its lowest, to the second picture and
  // leaves that bound as a texture. Requires: the framebuffer is bound, without the second picture.
  void keepRows(int lo, int hi) const;

  // RGBA of GL_COLOR_ATTACHMENT0 or 1 into `rgba`, top row first, whatever it held.
  void read(GLenum attachment, std::vector<float>& rgba);
  // The depths whose sums over a pixel's samples, weighted by opacity, the second picture has;
  // infinity where nothing shows, as renderers write it.
  void readDepth(std::vector<float>& depth);

 private:
  void makeFloats(GLuint texture, PictureSize size) const;
  // Copies the picture that is read upside down and lets the copy be read.
  void turn();

  const GlFunctions& gl_;
  bool inverts_;
  PictureSize size_{0, 0};
  GLuint framebuffer_ = 0, color_ = 0, second_ = 0;
  // Made if the driver reads rows upwards.
  PictureSize turned_size_{0, 0};
  GLuint turned_framebuffer_ = 0, turned_ = 0;
};

}  // namespace sluice
