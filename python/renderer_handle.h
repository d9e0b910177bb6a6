// A renderer as Python holds it. Calls from several threads of Python follow one another, each with
// the look that it asks for.
#pragma once

#include <pybind11/pybind11.h>
#include <sluice/renderer.h>

#include <cstdint>
#include <string>
#include <vector>

#include "python/keyword_rules.h"
#include "python/picture_options.h"
#include "python/volume_handle.h"
#include "src/base/threads/mutex.h"

namespace sluice::python {

class RendererHandle {
 public:
  // `device`: "auto", "gl" or "cpu"; `pipeline`: fields of PipelineOptions. Throws TypeError,
  // ValueError, Error.
  RendererHandle(const VolumeHandle& volume, const std::string& device, uint64_t memory_bytes,
                 int threads, const py::dict& pipeline);

  // python/sluice/__init__.py documents each method. `keywords`: picture_options.h.
  py::object render(const VolumeHandle& volume, const py::object& progress,
                    const py::kwargs& keywords);
  void save(const VolumeHandle& volume, const std::string& path, const py::object& progress,
            const py::kwargs& keywords);
  py::object probe(const VolumeHandle& volume, double right, double down,
                   const py::kwargs& keywords);
  py::array slice(int axis, int64_t at, int64_t time, int most);
  // The keys of `sluice plan --json` that tell of the picture.
  py::dict plan(const VolumeHandle& volume, const py::object& progress, const py::kwargs& keywords);
  py::dict report();
  std::string look() { return renderer_.get().lookText(); }
  std::string device() { return renderer_.get().deviceName(); }
  void recordTo(const std::string& path) { renderer_.get().recordTo(path); }

 private:
  enum class Use { kDrawn, kPlanned };

  // Calls with the renderer, once it has the look that is asked for, a ProgressFunction and a stop
  // token. Then the look's warnings are Python's, and those of keywords that change nothing.
  template <class Call>
  auto withLook(const AskedPicture& asked, const py::object& progress, Use use, const Call& call) {
    const LookOptions& look = asked.look;
    const ProgressFunction told = progressFunction(progress);
    Renderer& renderer = renderer_.get();
    std::vector<std::string> warnings;
    auto result = run([&](const std::stop_token& stop) {
      const MutexLock lock(mutex_);
      if (look != look_) {
        renderer.setLook(look);
        look_ = look;
      }
      auto drawn = call(renderer, told, stop);
      warnings = renderer.lookWarnings();
      const std::vector<std::string> idle =
          renderer.idleOptions(asked.given, asked.picture, use == Use::kPlanned);
      warnings.insert(warnings.end(), idle.begin(), idle.end());
      return drawn;
    });
    warn(warnings);
    return result;
  }

  // The same for a picture that is drawn; one that shows nothing has a warning that says why.
  template <class Call>
  auto drawn(const AskedPicture& asked, const py::object& progress, const Call& call) {
    std::string why_empty;
    auto result = withLook(
        asked, progress, Use::kDrawn,
        [&](Renderer& renderer, const ProgressFunction& told, const std::stop_token& stop) {
          auto picture = call(renderer, told, stop);
          why_empty = renderer.report().why_empty;
          return picture;
        });
    if (!why_empty.empty()) warn({"the picture shows nothing: " + why_empty});
    return result;
  }

  Held<Renderer> renderer_;
  Mutex mutex_;  // held while a look is set and drawn
  LookOptions look_ SLUICE_GUARDED_BY(mutex_);
};

}  // namespace sluice::python
