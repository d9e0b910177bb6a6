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
#include <sluice/report.h>
#include <sluice/screen.h>
#include <sluice/volume.h>

#include <array>
#include <memory>
#include <optional>
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

  // The same where RendererOptions::screen draws, over this background (red, green, blue, 0 to 1),
  // without reading it back. nullopt: nothing was drawn, because that context does not draw, or
  // because the picture is of another mode than composite or has depth. Throws as draw() does.
  std::optional<ScreenImage> drawOnScreen(const PictureOptions& picture,
                                          const std::array<float, 3>& background,
                                          const ProgressFunction& progress = {},
                                          const std::stop_token& stop = {});

  // One framing for pictures that belong together (a turn, a series), so that nothing grows or
  // shrinks from one to the next: sets view.framing of all but those with look_at. Their size, crop
  // and Fit are the first's. Throws as draw() does; nothing to do for no picture.
  void fit(std::span<PictureOptions> pictures, const ProgressFunction& progress = {},
           const std::stop_token& stop = {});

  // The same view by eye, target and what is up, for who moves it on: draws the same picture. The
  // target is what the view turns about. Throws as draw() does.
  ViewOptions placed(const PictureOptions& picture, const ProgressFunction& progress = {},
                     const std::stop_token& stop = {});

  // A picture that draw() gave for these options, with the look as it still is, as an OpenEXR file:
  // linear light, premultiplied, 32 bits a channel, with its depth if it has one, and in the header
  // the options of `sluice render` that make it again. The file appears whole or not at all, and
  // replaces one that is there. Throws as draw() does, and Error where the image is of another
  // size.
  void writeExr(const std::string& path, const Image& image, const PictureOptions& picture,
                const std::optional<std::array<float, 3>>& background = {});

  ShownLook shownLook() const;
  // Of the last picture and of the levels as they are now; `maps` costs a copy of theirs.
  RenderReport report(bool maps = false) const;

  // What first hides what lies behind it, along the ray through a point of the picture (0 to 1, to
  // the right and down): where half of the light is gone, or most was taken of what lets more
  // through; of maximum and minimum modes, where that is. nullopt: nothing shows there. Reads the
  // blocks on its way through level 2. Throws as draw() does.
  std::optional<VoxelProbe> probe(const PictureOptions& picture, double right, double down,
                                  const std::stop_token& stop = {});
  // Reads through level 2, within the budget. Throws as draw() does.
  SliceValues slice(const SliceOptions& slice, const std::stop_token& stop = {});

  // From now on each request of the texture cache is written to this file, in the format that its
  // name says as for `sluice render --trace`; empty: no longer. The file appears when it ends, or
  // with the Renderer's end. Throws Error.
  void recordTo(const std::string& path);

 private:
  struct Impl;
  Impl& impl() const;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sluice
