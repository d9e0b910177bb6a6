// Renderer: draws pictures of a volume, one after the other, and keeps the data that they share:
// blocks and textures within one budget, the device, and tables made from the look.
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
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

namespace sluice {

// Any thread may call; calls from several threads wait for each other, so a stop token, from
// whichever thread, ends a picture that is no longer wanted. Drawing runs on a thread of its own
// and leaves the caller's OpenGL context alone. Constructing the first Renderer may set environment
// variables that OpenGL drivers read (GALLIVM_PERF, EGL_LOG_LEVEL, LP_NUM_THREADS), each only if it
// is unset.
class Renderer {
 public:
  // Throws Error: nothing draws here, the memory is too little (the least that works is named), a
  // look that is none, as setLook() has it.
  explicit Renderer(const Volume& volume, const LookOptions& look = {},
                    const RendererOptions& options = {});
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  // Sets the look of pictures from now on. Throws Error and keeps the old look if a transfer
  // function's file cannot be read, a map is unknown, or opacities are invalid.
  void setLook(const LookOptions& look);

  // The options of `sluice render` that reproduce this look, even if it was chosen automatically.
  std::string lookText() const;
  // Possible mistakes in the look, one line each: a threshold beyond the values. Also
  // RenderReport::why_added of the last picture.
  std::vector<std::string> lookWarnings() const;
  // The options of `given` ("--fov", as for `sluice render`) that change nothing in a picture with
  // these options and the look as it is, one line each: another option, or the volume, leaves them
  // without an effect. `is_planned`: the picture is planned, and not drawn. Throws as draw() does.
  std::vector<std::string> idleOptions(const std::set<std::string>& given,
                                       const PictureOptions& picture, bool is_planned = false);
  // "osmesa, llvmpipe (...)".
  std::string deviceName() const;

  // Draws. Throws Error: options that are none, a size that the device cannot draw, a file that
  // cannot be read (any more), too little memory. Throws Cancelled when `stop` asks for it, within
  // a fraction of a second. After either, the next picture is right anyway.
  Image draw(const PictureOptions& picture = {}, const ProgressFunction& progress = {},
             const std::stop_token& stop = {});

  // The same picture in strips, for pictures that are too large for memory: `take` gets a few
  // rows at a time as an image of the picture's width, from the top row down. It is called on the
  // renderer's thread and may not call the renderer. A strip takes a quarter of memory_bytes, or
  // less if that is short. Throws as draw() does, and the errors of `take`.
  void drawRows(const PictureOptions& picture, const std::function<void(const Image& rows)>& take,
                const ProgressFunction& progress = {}, const std::stop_token& stop = {});

  // Draws in strips into a file: .png, or .exr as writeExr() writes it. In composite mode, an .exr
  // has depth. The file appears whole or not at all, and replaces one that is there. Throws as
  // draw() does, and Error if the file cannot be written.
  void drawToFile(const std::string& path, const PictureOptions& picture,
                  const std::optional<std::array<float, 3>>& background = {},
                  const ProgressFunction& progress = {}, const std::stop_token& stop = {});

  // The same as draw() if RendererOptions::screen draws, over this background (red, green, blue, 0
  // to 1), without reading it back. nullopt: nothing was drawn, because that context does not draw,
  // or because the picture has depth or a mode other than composite. Throws as draw() does.
  std::optional<ScreenImage> drawOnScreen(const PictureOptions& picture,
                                          const std::array<float, 3>& background,
                                          const ProgressFunction& progress = {},
                                          const std::stop_token& stop = {});

  // Frames pictures that belong together (a turn, a series) alike, so that nothing grows or shrinks
  // from one to the next: sets view.framing of all except those with look_at. The first picture's
  // size, crop and Fit apply to all. Throws as draw() does; nothing to do for no picture.
  void fit(std::span<PictureOptions> pictures, const ProgressFunction& progress = {},
           const std::stop_token& stop = {});

  // The same view by eye, target and up direction, for callers that move it; it draws the same
  // picture. The view turns about the target. Throws as draw() does.
  ViewOptions placed(const PictureOptions& picture, const ProgressFunction& progress = {},
                     const std::stop_token& stop = {});

  // A picture that draw() gave for these options, with the look as it still is, as an OpenEXR file:
  // linear light, premultiplied, 32 bits a channel, with its depth if it has one, and in the header
  // the options of `sluice render` that make it again. The file appears whole or not at all, and
  // replaces one that is there. Throws as draw() does, and Error if the image is of another size.
  void writeExr(const std::string& path, const Image& image, const PictureOptions& picture,
                const std::optional<std::array<float, 3>>& background = {});

  ShownLook shownLook() const;
  // The last picture and the levels as they are now. `maps` copies the maps too.
  RenderReport report(bool maps = false) const;

  // The cost of a picture with these options and the look as it is. No voxel is read, unless the
  // time step has no index yet. Throws as draw() does.
  PicturePlan plan(const PictureOptions& picture = {}, const ProgressFunction& progress = {},
                   const std::stop_token& stop = {});

  // How draw() samples a picture with these options and the look as it is. Throws as draw() does.
  PictureSampling sampling(const PictureOptions& picture = {},
                           const ProgressFunction& progress = {}, const std::stop_token& stop = {});

  // The place that first hides what lies behind it, along the ray through a point of the picture (0
  // to 1, to the right and down): where half of the light is gone, or, if more passes, where most
  // was taken. In maximum and minimum modes, the place of the extreme. nullopt: nothing shows
  // there. Reads the blocks along the ray through level 2. Throws as draw() does.
  std::optional<VoxelProbe> probe(const PictureOptions& picture, double right, double down,
                                  const std::stop_token& stop = {});
  // Reads through level 2, within the budget. Throws as draw() does.
  SliceValues slice(const SliceOptions& slice, const std::stop_token& stop = {});

  // From now on each request of the texture cache is written to this file, in the format of its
  // name as for `sluice render --trace`; empty: no longer. The file appears when it ends, or with
  // the Renderer's end. Several channels have a file each, "t_0.txt" and "t_over.txt" for "t.txt".
  // Throws Error.
  void recordTo(const std::string& path);

 private:
  struct Impl;
  Impl& impl() const;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sluice
