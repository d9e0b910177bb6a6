// Drawing: what the public Renderer does, on the one thread that the device is of: a volume, its
// device and session, and the look. It keeps what fitting has found beside what the session keeps.
#pragma once

#include <sluice/image.h>
#include <sluice/options.h>
#include <sluice/report.h>
#include <sluice/screen.h>

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cache/trace/trace.h"
#include "src/device/screen_picture.h"
#include "src/library/chosen_look.h"
#include "src/library/opened_volume.h"
#include "src/library/progress_relay.h"
#include "src/library/requests.h"
#include "src/render/memo.h"
#include "src/render/session.h"

namespace sluice {

class Drawing {
 public:
  // Makes the device. Throws Error.
  Drawing(std::shared_ptr<const OpenedVolume> opened, const LookOptions& look,
          const RendererOptions& options);
  // Ends the trace, if any; what goes wrong with it is not said any more.
  ~Drawing();
  Drawing(const Drawing&) = delete;
  Drawing& operator=(const Drawing&) = delete;

  // See Renderer. These throw Interrupted where it throws Cancelled.
  void setLook(const LookOptions& look);
  const ChosenLook& look() const { return look_; }
  std::string deviceName() const;
  Image draw(const PictureOptions& picture, ProgressTeller& teller);
  std::optional<ScreenImage> drawOnScreen(const PictureOptions& picture,
                                          const std::array<float, 3>& background,
                                          ProgressTeller& teller);
  void fit(std::span<PictureOptions> pictures, ProgressTeller& teller);
  ViewOptions placed(const PictureOptions& picture, ProgressTeller& teller);
  void writeExr(const std::string& path, const Image& image, const PictureOptions& picture,
                const std::optional<std::array<float, 3>>& background);
  ShownLook shownLook() const;
  RenderReport report(bool maps) const;
  std::optional<VoxelProbe> probe(const PictureOptions& picture, double right, double down,
                                  ProgressTeller& teller);
  SliceValues slice(const SliceOptions& slice, ProgressTeller& teller);
  void recordTo(const std::string& path);

 private:
  using Points = std::shared_ptr<const std::vector<Vec3d>>;
  struct PointsKey {
    int64_t time;
    std::optional<Box3> crop;
    int64_t look;
    friend bool operator==(const PointsKey&, const PointsKey&) = default;
  };

  // All but what the look and the machine say, its camera framed.
  FrameOptions framed(const PictureOptions& picture, const TimeStep& step, const IndexPass& pass);
  // The same with what follows from the look.
  FrameOptions looked(const PictureOptions& picture, const TimeStep& step, const IndexPass& pass);
  std::vector<uint8_t> blockClasses() const;
  // In the series' range of values. Throws Error when the volume has no such step.
  TimeStep stepAt(int64_t time, const IndexPass& pass);
  // Framed for pictures from all these cameras together; null where they have what they need.
  std::optional<Framing> framingFor(const std::vector<Camera>& cameras, FitChoice choice,
                                    const FrameOptions& options, const TimeStep& step,
                                    const IndexPass& pass);
  const VolumeLayout& layout() const { return opened_->volume.source->layout(); }

  const std::shared_ptr<const OpenedVolume> opened_;
  const MachineOptions machine_;
  WorkerPool pool_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<Session> session_;
  Mode mode_ = Mode::kComposite;
  ChosenLook look_;
  int64_t looks_ = 0;  // that were set so far
  // Of the step that is drawn and of the one that is read ahead.
  std::array<Memo<int64_t, const IndexedRanges>, 2> ranges_;
  FrameReport report_;                 // of the last frame
  std::string why_empty_;              // RenderReport::why_empty
  DrawsForScreens* screen_ = nullptr;  // the device, where it draws in a context that was lent
  std::unique_ptr<TraceWriter> trace_;
  Memo<PointsKey, const std::vector<Vec3d>> points_;
};

}  // namespace sluice
