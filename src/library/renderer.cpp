#include <sluice/renderer.h>

#include <utility>

#include "src/base/error.h"
#include "src/library/conversions.h"
#include "src/library/drawing/drawing.h"
#include "src/library/own_thread.h"

namespace sluice {

// The drawing is the own thread's alone, from its making to its end.
struct Renderer::Impl {
  explicit Impl(OwnThread::Runs runs) : own(runs) {}

  OwnThread own;
  std::unique_ptr<Drawing> drawing;

  // Runs `call` on the renderer's own thread and returns its result.
  template <class Call>
  auto on(const Call& call) {
    return translated([&] {
      std::optional<decltype(call(*drawing))> result;
      own.run([&] { result = call(*drawing); });
      return std::move(*result);
    });
  }
  ~Impl() {
    try {
      own.run([&] { drawing.reset(); });
    } catch (...) {  // no memory on the other thread: run here
      drawing.reset();
    }
  }
};

Renderer::Renderer(const Volume& volume, const LookOptions& look, const RendererOptions& options) {
  volume.info();  // throws if there is none
  const InSitu* in_situ = volume.impl_->in_situ.get();
  // Ranks meet on the thread that may call MPI, which is the caller's.
  impl_ = std::make_unique<Impl>(in_situ == nullptr ? OwnThread::Runs::kOnOwn
                                                    : OwnThread::Runs::kOnCallers);
  const auto make = [&] {
    impl_->own.run(
        [&] { impl_->drawing = std::make_unique<Drawing>(volume.impl_, look, options); });
    return true;
  };
  translated([&] { return in_situ == nullptr ? make() : together(in_situ->team(), make); });
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Renderer::Impl& Renderer::impl() const {
  if (impl_ == nullptr) failRequest("a Renderer that was moved from: it draws no more");
  return *impl_;
}

void Renderer::setLook(const LookOptions& look) {
  impl().on([&](Drawing& drawing) {
    drawing.setLook(look);
    return true;
  });
}

std::string Renderer::lookText() const {
  return impl().on([](Drawing& drawing) { return drawing.lookText(); });
}

std::vector<std::string> Renderer::lookWarnings() const {
  return impl().on([](Drawing& drawing) { return drawing.lookWarnings(); });
}

std::vector<std::string> Renderer::idleOptions(const std::set<std::string>& given,
                                               const PictureOptions& picture, bool is_planned) {
  return impl().on(
      [&](Drawing& drawing) { return drawing.idleOptions(given, picture, is_planned); });
}

std::string Renderer::deviceName() const {
  return impl().on([](Drawing& drawing) { return drawing.deviceName(); });
}

Image Renderer::draw(const PictureOptions& picture, const ProgressFunction& progress,
                     const std::stop_token& stop) {
  return impl().on([&](Drawing& drawing) {
    ProgressTeller teller(progress, stop);
    return drawing.draw(picture, teller);
  });
}

void Renderer::drawRows(const PictureOptions& picture,
                        const std::function<void(const Image& rows)>& take,
                        const ProgressFunction& progress, const std::stop_token& stop) {
  impl().on([&](Drawing& drawing) {
    ProgressTeller teller(progress, stop);
    drawing.drawRows(picture, take, teller);
    return true;
  });
}

void Renderer::drawToFile(const std::string& path, const PictureOptions& picture,
                          const std::optional<std::array<float, 3>>& background,
                          const ProgressFunction& progress, const std::stop_token& stop) {
  impl().on([&](Drawing& drawing) {
    ProgressTeller teller(progress, stop);
    drawing.drawToFile(path, picture, background, teller);
    return true;
  });
}

std::optional<ScreenImage> Renderer::drawOnScreen(const PictureOptions& picture,
                                                  const std::array<float, 3>& background,
                                                  const ProgressFunction& progress,
                                                  const std::stop_token& stop) {
  return impl().on([&](Drawing& drawing) {
    ProgressTeller teller(progress, stop);
    return drawing.drawOnScreen(picture, background, teller);
  });
}

void Renderer::fit(std::span<PictureOptions> pictures, const ProgressFunction& progress,
                   const std::stop_token& stop) {
  impl().on([&](Drawing& drawing) {
    ProgressTeller teller(progress, stop);
    drawing.fit(pictures, teller);
    return true;
  });
}

ViewOptions Renderer::placed(const PictureOptions& picture, const ProgressFunction& progress,
                             const std::stop_token& stop) {
  return impl().on([&](Drawing& drawing) {
    ProgressTeller teller(progress, stop);
    return drawing.placed(picture, teller);
  });
}

void Renderer::writeExr(const std::string& path, const Image& image, const PictureOptions& picture,
                        const std::optional<std::array<float, 3>>& background) {
  impl().on([&](Drawing& drawing) {
    drawing.writeExr(path, image, picture, background);
    return true;
  });
}

ShownLook Renderer::shownLook() const {
  return impl().on([](Drawing& drawing) { return drawing.shownLook(); });
}

RenderReport Renderer::report(bool maps) const {
  return impl().on([&](Drawing& drawing) { return drawing.report(maps); });
}

PicturePlan Renderer::plan(const PictureOptions& picture, const ProgressFunction& progress,
                           const std::stop_token& stop) {
  return impl().on([&](Drawing& drawing) {
    ProgressTeller teller(progress, stop);
    return drawing.plan(picture, teller);
  });
}

PictureSampling Renderer::sampling(const PictureOptions& picture, const ProgressFunction& progress,
                                   const std::stop_token& stop) {
  return impl().on([&](Drawing& drawing) {
    ProgressTeller teller(progress, stop);
    return drawing.sampling(picture, teller);
  });
}

std::optional<VoxelProbe> Renderer::probe(const PictureOptions& picture, double right, double down,
                                          const std::stop_token& stop) {
  return impl().on([&](Drawing& drawing) {
    const ProgressFunction nobody;
    ProgressTeller teller(nobody, stop);
    return drawing.probe(picture, right, down, teller);
  });
}

SliceValues Renderer::slice(const SliceOptions& slice, const std::stop_token& stop) {
  return impl().on([&](Drawing& drawing) {
    const ProgressFunction nobody;
    ProgressTeller teller(nobody, stop);
    return drawing.slice(slice, teller);
  });
}

void Renderer::recordTo(const std::string& path) {
  impl().on([&](Drawing& drawing) {
    drawing.recordTo(path);
    return true;
  });
}

}  // namespace sluice
