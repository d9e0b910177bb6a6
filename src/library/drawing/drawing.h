// Drawing: the work of the public Renderer, on the one thread that owns the device: a scene, and
// public options and reports in place of its own. It keeps the results of fitting in addition to
// what the scene keeps.
//
// The folder: here, the calls of the public Renderer and answers about a picture (probing.h,
// view_fit.h, empty_picture.h). scene/ has what is drawn, cost/ what a picture costs before it is
// drawn, and files/ the files that it is written to.
#pragma once

#include <sluice/image.h>
#include <sluice/options.h>
#include <sluice/report.h>
#include <sluice/screen.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "src/device/pictures/screen_picture.h"
#include "src/library/drawing/scene/scene.h"
#include "src/library/opening/opened_volume.h"
#include "src/library/progress_relay.h"
#include "src/render/blocks/memo.h"

namespace sluice {

class Drawing {
 public:
  // Makes the device. Throws Error.
  Drawing(std::shared_ptr<const OpenedVolume> opened, const LookOptions& look,
          const RendererOptions& options);
  // Ends the trace, if any; a failure to write it is ignored here.
  ~Drawing();
  Drawing(const Drawing&) = delete;
  Drawing& operator=(const Drawing&) = delete;

  // See Renderer. These throw Interrupted when the Renderer throws Cancelled.
  void setLook(const LookOptions& look);
  const ChosenLook& look() const { return scene_.look; }
  std::vector<std::string> lookWarnings() const { return scene_.lookWarnings(); }
  std::string lookText() const { return scene_.lookText(); }
  std::vector<std::string> idleOptions(const std::set<std::string>& given,
                                       const PictureOptions& picture, bool is_planned);
  std::string deviceName() const;
  Image draw(const PictureOptions& picture, ProgressTeller& teller);
  void drawRows(const PictureOptions& picture, const std::function<void(const Image& rows)>& take,
                ProgressTeller& teller);
  void drawToFile(const std::string& path, const PictureOptions& picture,
                  const std::optional<std::array<float, 3>>& background, ProgressTeller& teller);
  std::optional<ScreenImage> drawOnScreen(const PictureOptions& picture,
                                          const std::array<float, 3>& background,
                                          ProgressTeller& teller);
  void fit(std::span<PictureOptions> pictures, ProgressTeller& teller);
  ViewOptions placed(const PictureOptions& picture, ProgressTeller& teller);
  void writeExr(const std::string& path, const Image& image, const PictureOptions& picture,
                const std::optional<std::array<float, 3>>& background);
  ShownLook shownLook() const;
  RenderReport report(bool maps) const;
  PicturePlan plan(const PictureOptions& picture, ProgressTeller& teller);
  PictureSampling sampling(const PictureOptions& picture, ProgressTeller& teller);
  std::optional<VoxelProbe> probe(const PictureOptions& picture, double right, double down,
                                  ProgressTeller& teller);
  SliceValues slice(const SliceOptions& slice, ProgressTeller& teller);
  void recordTo(const std::string& path);

 private:
  struct Reading;
  using Points = std::shared_ptr<const std::vector<Vec3d>>;
  struct PointsKey {
    int64_t time;
    std::optional<Box3> crop;
    int64_t look;
    friend bool operator==(const PointsKey&, const PointsKey&) = default;
  };

  // Throws Error if ranks draw together and a call is not one for all of them.
  void refuseInSitu(const char* call) const;
  // Ranks that draw together compare what they are asked for, before anything that all have to do,
  // and what they draw. Throws Error, at all of them.
  void expectSameRequest(const PictureOptions& picture) const;
  void expectSamePicture(const PictureOptions& picture, const FrameOptions& options,
                         const View& view) const;
  // The corners of what shows of the boxes of all ranks.
  std::vector<Vec3d> pointsOfRanks(const std::vector<Vec3d>& own) const;

  // A frame that the session is ready to draw.
  struct ReadyFrame {
    FrameOptions options;
    int64_t time;
  };
  ReadyFrame ready(const PictureOptions& picture, const IndexPass& pass, ProgressTeller& teller);
  // Draws the frame whole. `kept`: set to the picture that stays on the device; null: pixels come.
  Image drawWhole(const PictureOptions& picture, std::optional<ScreenPicture>* kept,
                  ProgressTeller& teller);
  SceneFrame drawFrame(const ReadyFrame& frame, const std::vector<PictureRows>& strips,
                       const std::function<void(const Picture& rows)>& take,
                       ProgressTeller& teller);
  // Keeps a frame's part of report().
  void keepReport(const ReadyFrame& frame, const SceneFrame& drawn, const IndexPass& pass);
  // All options except those of the look and the machine. Throws Error if one is invalid.
  FrameOptions asked(const PictureOptions& picture) const;
  // The same with the camera framed.
  FrameOptions framed(const PictureOptions& picture, const TimeStep& step, const IndexPass& pass);
  // The same with the options that follow from the look. The scene combines its layers as such a
  // frame does from now on; the session stays, since not every such frame is drawn.
  FrameOptions looked(const PictureOptions& picture, const TimeStep& step, const IndexPass& pass);
  // Makes sure that the session is open and has memory for such a frame, of which the scene knows
  // the combining. Its contents stay unless the memory has to be shared out in another way. Throws
  // Error if the memory is too little; pictures as before can be drawn then.
  void openSessionFor(const FrameOptions& options);
  // The open session. Throws Error if it failed to open.
  Session& session() const;
  std::vector<uint8_t> blockClasses() const;
  // The step of each channel with the series' range of values. Throws Error when the volume has no
  // such step.
  std::vector<TimeStep> stepsAt(int64_t time, const IndexPass& pass);
  TimeStep stepAt(int64_t time, const IndexPass& pass) { return stepsAt(time, pass).front(); }
  // The corners of what the looks show, see visiblePoints().
  Points shownPoints(const FrameOptions& options, const TimeStep& step, const IndexPass& pass);
  // The framing for pictures from all these cameras together; null if they need none.
  std::optional<Framing> framingFor(const std::vector<Camera>& cameras, FitChoice choice,
                                    const FrameOptions& options, const TimeStep& step,
                                    const IndexPass& pass);
  const VolumeLayout& layout() const { return opened_->volume.source->layout(); }

  const std::shared_ptr<const OpenedVolume> opened_;
  LookOptions asked_look_;
  Scene scene_;
  Mode mode_;
  FrameOptions session_frame_;  // frames that the session has memory for
  Combine session_combine_;     // and how their layers are combined
  const PipelineOptions pipeline_;
  int64_t looks_ = 0;  // looks set so far
  // The step that is drawn and the one that is read ahead.
  std::array<Memo<int64_t, const std::vector<TimeStep>>, 2> steps_;
  FrameReport report_;                 // report of the last frame
  std::string why_empty_;              // RenderReport::why_empty
  std::string empty_channels_;         // RenderReport::empty_channels
  DrawsForScreens* screen_ = nullptr;  // the device, if it draws in a context that was lent
  Memo<PointsKey, const std::vector<Vec3d>> points_;
};

}  // namespace sluice
