// The output of `render` about its frames: JSON, a page, or lines for people.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <vector>

#include "src/library/drawing/scene/refined_frame.h"
#include "tools/commands/verification.h"
#include "tools/options/render_arguments.h"
#include "tools/outputs/report.h"
#include "tools/scene/open_scene.h"
#include "tools/scene/series.h"

namespace CLI {
class App;
}

namespace sluice {

// The result of drawing; picture, blocks and names are the last frame's.
struct Drawn {
  std::vector<RenderedFrame> frames;
  std::vector<nlohmann::json> culling;               // one per frame, if blocks are culled
  std::vector<std::vector<RefinedPicture>> refined;  // one per frame, if it is a row of pictures
  std::filesystem::path name;
  std::vector<std::filesystem::path> views;
  Picture picture;
  double step_vox = 0;  // between its slices
  VisibleBlocksPtr blocks;
  bool is_cut = false;  // a signal came: the frames that were drawn until then
};

// `to_draw`: the numbers of its frames.
nlohmann::json reportOf(const RenderArguments& arguments, const CLI::App& app,
                        const std::vector<int64_t>& to_draw, const Drawn& drawn,
                        const Scene& scene);
// With --continue, the --report file of an earlier run, as JSON; null if there is none. Called
// before the report is replaced. Throws Error and Interrupted.
nlohmann::json earlierReport(const RenderArguments& arguments);
// Prints a line if the earlier report is of a run whose pictures look otherwise: it names the first
// option that differs.
void warnOfOtherOptions(const RenderArguments& arguments, const CLI::App& app,
                        const nlohmann::json& earlier);
// With --continue: `frames` becomes the list of the whole series. Pictures that were there already
// have the figures of the earlier report; those that no report has measured are named in
// `frames_not_measured`.
void addEarlierFrames(const RenderArguments& arguments, const nlohmann::json& earlier,
                      nlohmann::json& report);
// `maps`: blocks are known whole, as one process alone knows them. Throws Error.
void writeReportOf(const RenderArguments& arguments, const nlohmann::json& report,
                   const Drawn& drawn, const Scene& scene, bool maps);
void printDrawn(const RenderArguments& arguments, const Scene& scene, const Series& series,
                const Drawn& drawn, const std::optional<Verification>& verified);
// Prints one line, about the first picture that shows nothing, if any.
void warnOfEmptyPictures(const RenderArguments& arguments, const std::vector<int64_t>& drawn_frames,
                         const Drawn& drawn);
// Replaces all that if --continue finds nothing to draw.
void sayAllAreThere(const RenderArguments& arguments, const CLI::App& app);

}  // namespace sluice
