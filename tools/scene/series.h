// Series: the time steps of a scene that a command shows one after another, with culling or
// without.
#pragma once

#include <nlohmann/json.hpp>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "src/library/opening/series_functions.h"
#include "src/render/blocks/culled_blocks.h"
#include "tools/scene/open_scene.h"

namespace sluice {

// The names in `--basis`.
std::vector<std::string> basisFiles(const CullingArguments& culling);
// Throws Error if one of them is no transfer function, whatever becomes of it later.
void checkBasis(const CullingArguments& culling);
// Throws Error, also from a basis' file.
SeriesOptions seriesOptions(const CullingArguments& culling, const IndexedVolume& volume);

// The functions of an opened volume, read or made with progress; prints their notes. Throws Error.
SeriesFunctions openFunctions(const IndexedVolume& volume, const TransferFunction& transfer,
                              const CullingArguments& culling, const ResourceArguments& resources,
                              WorkerPool& pool);
// An eighth of the memory is for what is kept from step to step.
CullingOptions cullingOptions(Culling culling, const FrameOptions& frame,
                              const SeriesFunctions& functions, uint64_t memory_bytes);

// The decision of --culling auto, and the reason for it.
struct CullingChoice {
  bool culls = false;
  // Seconds of a step drawn either way; absent if none was measured.
  std::optional<double> none_seconds, culled_seconds;
  std::string line;  // for people
};

class Series {
 public:
  // A series shorter than this is drawn without culling by --culling auto: the cost of drawing five
  // more steps would not be small.
  static constexpr size_t kLeastMeasured = 64;

  // `scene` must outlive it, and was opened for the whole series. `frame`: the options of its
  // pictures. Throws Error.
  Series(Scene& scene, const CullingArguments& culling, const ResourceArguments& resources,
         const FrameOptions& frame);
  ~Series();
  Series(const Series&) = delete;
  Series& operator=(const Series&) = delete;

  // --culling auto: draws the first five of the steps with culling and without by turns and keeps
  // no picture of them. It culls from now on if the faster of two steps took a tenth less with
  // culling. The first of the five is not counted: it looks at all tiles of the picture, which
  // others do not; but if it hides hardly any block, no other is drawn. Requires: the session's
  // options are those of the first picture.
  void choose(std::span<const int64_t> times);

  // The scene's next frame shows this step; while its last is drawn, what `next` needs is read.
  void show(int64_t time, std::optional<int64_t> next);

  // True with culling; counts() are then the last frame's.
  bool culls() const { return culled_.has_value(); }
  const CullingCounts& counts() const { return culled_->countsOf(shown_); }
  const std::optional<CullingChoice>& choice() const { return choice_; }
  const SeriesFunctions* functions() const { return functions_ ? &*functions_ : nullptr; }

  // The step of each channel of the scene, kept until it is shown.
  const std::vector<TimeStep>& steps(int64_t time);

 private:
  // Seconds that drawing a step takes either way.
  double secondsOf(int64_t time, bool culls);
  CullingChoice measure(std::span<const int64_t> times);

  Scene& scene_;
  const FrameOptions frame_;
  const bool is_auto_;
  std::optional<CullingChoice> choice_;
  std::optional<SeriesFunctions> functions_;
  std::optional<CulledBlocks> culled_;
  std::vector<TimeStep> next_;  // empty: not known
  int64_t shown_ = -1;
};

// `blocks_nonempty`, `visible`, `estimate_seconds`, `pixels_checked`.
nlohmann::json countsJson(const CullingCounts& counts);
// `culls`, `line`, and `seconds` of each way if they were measured.
nlohmann::json choiceJson(const CullingChoice& choice);

}  // namespace sluice
