// Series: the time steps of a scene that a command shows one after another, with culling or
// without.
#pragma once

#include <nlohmann/json.hpp>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/library/series_functions.h"
#include "src/render/culled_blocks.h"
#include "tools/scene.h"

namespace sluice {

// The names in `--basis`.
std::vector<std::string> basisFiles(const CullingArguments& culling);
// Throws Error, also from a basis' file.
SeriesOptions seriesOptions(const CullingArguments& culling, const IndexedVolume& volume);

// The functions of an opened volume, read or made with progress; prints their notes. Throws Error.
SeriesFunctions openFunctions(const IndexedVolume& volume, const TransferFunction& transfer,
                              const CullingArguments& culling, const ResourceArguments& resources,
                              WorkerPool& pool);
CullingOptions cullingOptions(Culling culling, const FrameOptions& frame,
                              const SeriesFunctions& functions);

class Series {
 public:
  // `scene` must outlive it, and was opened for the whole series. Throws Error.
  Series(Scene& scene, const CullingArguments& culling, const ResourceArguments& resources,
         const FrameOptions& frame);
  ~Series();
  Series(const Series&) = delete;
  Series& operator=(const Series&) = delete;

  // The scene's next frame shows this step; while its last is drawn, what `next` needs is read.
  void show(int64_t time, std::optional<int64_t> next);

  // With culling, of the last frame.
  bool culls() const { return culled_.has_value(); }
  const CullingCounts& counts() const { return culled_->countsOf(shown_); }
  const SeriesFunctions* functions() const { return functions_ ? &*functions_ : nullptr; }

 private:
  TimeStep step(int64_t time);

  Scene& scene_;
  const ResourceArguments& resources_;
  std::optional<SeriesFunctions> functions_;
  std::optional<CulledBlocks> culled_;
  std::optional<TimeStep> next_;
  int64_t shown_ = -1;
};

// `blocks_nonempty`, `visible`, `estimate_seconds`, `pixels_checked`.
nlohmann::json countsJson(const CullingCounts& counts);

}  // namespace sluice
