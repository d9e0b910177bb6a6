// sluice bench view: how soon a window would have a picture after a movement of the hand, and
// whether its loop ever waits.
#pragma once

#include <nlohmann/json.hpp>

#include "src/view/drawing/drawing_thread.h"

namespace sluice {

// The thing that the hand moves.
enum class DragKind { kThreshold, kView };

struct ViewBench {
  ViewedVolume volume;
  DrawingOptions drawing;
  int width = 800, height = 600;
  DragKind drag = DragKind::kThreshold;
  double threshold = 0;  // start of a drag of the threshold
  int events = 120;      // events of a drag
  double events_per_second = 60;
  int drags = 3;
};

// Opens the volume and waits for the first picture, then drags the threshold or turns the view back
// and forth with a hand's events, lets go, and waits for the whole picture:
// {"first_picture_seconds", "answer_seconds": {"p50", "p95", "max"}, "complete_seconds",
// "steady_frame_seconds", "loop_seconds": {"p50", "p95", "max"}, ...}. The first picture's seconds
// count from the call. The loop's times are those of one turn of the thread that stands for the
// window's, which asks and takes. Throws Error.
nlohmann::json benchView(const ViewBench& bench);
void printView(const nlohmann::json& report);

}  // namespace sluice
