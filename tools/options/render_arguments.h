// The arguments of `render`, and functions of them alone. Plain data.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "src/base/files/numbered_name.h"
#include "src/library/drawing/scene/refined_frame.h"
#include "src/library/drawing/view_fit.h"
#include "src/render/camera/camera_path.h"
#include "tools/options/arguments.h"
#include "tools/options/table_options.h"
#include "tools/outputs/film_file.h"
#include "tools/outputs/picture_output.h"

namespace sluice {

struct RenderArguments {
  VolumeArguments volume;
  LookArguments look;
  FrameOptions frame;
  RowEnd end = RowEnd::kCut;  // of a row of pictures that get better
  ResourceArguments resources;
  FitChoice fit;
  AskedView asked;
  std::optional<Aovs> aovs;
  bool annotate = false;
  std::string output;
  std::string report_file;
  std::string path_file;
  std::optional<CameraPath> path;  // of path_file, see readPath()
  std::string trace_file;
  std::string state_file;
  int64_t frames = 1;
  double frames_per_second = 25;  // for a film
  std::optional<TimeRange> times;
  CullingArguments culling;
  bool resume = false;
  bool progressive = false;  // writes each picture of a frame that gets better
  bool force = false;
  bool verify = false;
  bool debug_view = false;
  bool json = false;
};

// Pictures of a turn, of a path or of a range of time steps, at least 1.
inline int64_t frameCount(const RenderArguments& arguments) {
  return arguments.times ? arguments.times->count() : arguments.frames;
}

// The time step of a frame, counted from 0.
inline int64_t timeOf(const RenderArguments& arguments, int64_t frame) {
  return arguments.times ? arguments.times->at(frame) : arguments.volume.time;
}

// True if frames go through tools/scene/series.h, which reads ahead and culls.
inline bool isSeries(const RenderArguments& arguments) {
  return arguments.times || arguments.culling.culling != Culling::kNone;
}

// Whether a frame of a volume with levels is a row of pictures that get better.
inline bool asksForRefinement(const RenderArguments& arguments) {
  return (arguments.frame.time_limit_s || arguments.progressive) && arguments.asked->level != 0;
}

inline bool wantsReport(const RenderArguments& arguments) {
  return !arguments.report_file.empty() || arguments.json;
}

// Frames of a turntable are numbered from 0, pictures of a series by their time steps.
inline std::filesystem::path frameName(const RenderArguments& arguments, int64_t frame) {
  const bool is_turn = arguments.frames > 1;
  if (isFilmName(arguments.output)) return arguments.output;
  return numberedName(arguments.output, is_turn ? frame : timeOf(arguments, frame),
                      frameCount(arguments) > 1);
}

}  // namespace sluice
