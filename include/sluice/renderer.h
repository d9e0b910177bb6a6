// Renderer: draws pictures of a volume, one after the other, and keeps between them what they have
// in common: blocks and textures within one budget, the device, what follows from the look.
//
//   const sluice::Volume volume("head.nrrd");
//   sluice::Renderer renderer(volume, {.threshold = 300});
//   renderer.draw().writePng("head.png");
//
// A picture is the one that `sluice render` makes with the same options on the same device.
#pragma once

#include <sluice/error.h>
#include <sluice/image.h>
#include <sluice/options.h>
#include <sluice/progress.h>
#include <sluice/volume.h>

#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

namespace sluice {

// Any thread; calls from several wait for each other, so that a picture that is not wanted any more
// is ended by its stop token, from whichever thread. What draws runs on a thread of its own: an
// OpenGL context that the caller has stays as it is. Making the first one may set variables of the
// environment that OpenGL drivers read (GALLIVM_PERF, EGL_LOG_LEVEL, LP_NUM_THREADS), each only
// where it is unset.
class Renderer {
 public:
  // Throws Error: nothing draws here, the memory is too little (the least that works is named), a
  // look that is none, as setLook() has it.
  explicit Renderer(const Volume& volume, const LookOptions& look = {},
                    const RendererOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  // Of pictures from now on. Throws Error, and leaves the look as it was: a transfer function's
  // file that cannot be read, a map that is not known, opacities that are none.
  void setLook(const LookOptions& look);

  // The options of `sluice render` that give this look, also where it was chosen.
  std::string lookText() const;
  // What may be a mistake in the look, one line each: a threshold beyond the values.
  std::vector<std::string> lookWarnings() const;
  // "osmesa, llvmpipe (...)".
  std::string deviceName() const;

  // Draws. Throws Error: options that are none, a size that the device cannot draw, a file that
  // cannot be read (any more), too little memory. Throws Cancelled when `stop` asks for it, within
  // a fraction of a second. After either the next picture is right all the same.
  Image draw(const PictureOptions& picture = {}, const ProgressFunction& progress = {},
             const std::stop_token& stop = {});

  // One framing for pictures that belong together (a turn, a series), so that nothing grows or
  // shrinks from one to the next: sets view.framing of all but those with look_at. Their size, crop
  // and Fit are the first's. Throws as draw() does; nothing to do for no picture.
  void fit(std::span<PictureOptions> pictures, const ProgressFunction& progress = {},
           const std::stop_token& stop = {});

 private:
  struct Impl;
  Impl& impl() const;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sluice
