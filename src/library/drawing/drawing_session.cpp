// The session of a Drawing: opened anew if pictures share out the memory in another way, and
// recorded.
#include <exception>

#include "src/base/error.h"
#include "src/library/drawing/drawing.h"

namespace sluice {

void Drawing::openSessionFor(const FrameOptions& options) {
  FrameOptions frame = session_frame_;
  // Light that looks around has a share of the memory from the first such picture on.
  const bool is_new_light = options.lighting.looksAround() && !frame.lighting.looksAround();
  if (is_new_light) frame.lighting = options.lighting;
  // Blended channels need pages for equal numbers of blocks.
  if (scene_.isOpen() && !is_new_light) return;
  try {
    scene_.openSession(frame, noMoreBytes);
  } catch (...) {
    // The pictures before had enough memory, and such pictures can be drawn again.
    scene_.combine = session_combine_;
    scene_.openSession(session_frame_, noMoreBytes);
    throw;
  }
  session_frame_ = frame;
  session_combine_ = scene_.combine;
}

Session& Drawing::session() const {
  if (scene_.session == nullptr)
    failRequest("the last picture could not be drawn, and nothing is held in memory");
  return *scene_.session;
}

void Drawing::recordTo(const std::string& path) {
  if (!path.empty()) {
    session();  // throws if there is none to record
    scene_.requireNoOtherFiles(path);
  }
  scene_.recordTo(path);
}

Drawing::~Drawing() {
  try {
    scene_.keepLearntRanges();
    recordTo({});
  } catch (const std::exception&) {  // NOLINT: nobody is there to be told
  }
}

}  // namespace sluice
