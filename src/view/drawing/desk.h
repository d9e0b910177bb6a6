// Desk: the interface between a window and the code that draws for it: requests one way, news the
// other. The window (src/view/window) knows this, plain data and pure functions; nothing of it
// waits for a disk or for a picture.
#pragma once

#include <sluice/report.h>
#include <sluice/screen.h>
#include <sluice/volume.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/options/view_state.h"
#include "src/view/state/view_path.h"

namespace sluice {

enum class FileKind;  // src/base/files/file_kind.h

// The picture that the user wants to see now. A newer wish replaces those that were not drawn yet.
struct Wish {
  ViewState state = {};
  int width = 1, height = 1;              // pixels of the pane
  bool moves = false;                     // a hand is on it: more will follow
  std::optional<int64_t> next_time = {};  // next step of a series that plays
  // Processor time that showing a picture takes from drawing it; a preview has this much less.
  double showing_s = 0;
};

// Frames to be written, numbered from 0 in the place that the name has for it.
struct FilmWish {
  std::string name;  // "frame_%04d.png"
  ViewPath path;
  ViewState now;              // see stateAt()
  int width = 1, height = 1;  // pixels
};

// Pixels for a screen: rows from the top, red first, opaque.
struct ShownPicture {
  uint64_t wish = 0;  // number of the newest wish that it shows
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;
  std::optional<ScreenImage> screen;  // in place of rgba, where the desk draws for a screen
  bool is_complete = false;  // of the pane's size, at the wished step, with nothing missing
  double missing_share = 0;  // see Image
  std::string why_empty;     // see RenderReport
  std::string why_added;     // the same, in the words of the window
  // Levels of resolution in it, the finest first, see RenderReport; empty: the volume has one.
  std::vector<int> levels;
  bool will_improve = false;  // a better picture of this wish follows
  bool is_refined = true;     // see RenderReport
  ViewState state;            // that it shows
  double seconds = 0;         // that drawing it took
};

// The plane `at` of an axis, as grey values of the range of the look.
struct ShownSlice {
  int axis = 0;
  int64_t at = 0, time = 0;
  int width = 0, height = 0;
  std::vector<uint8_t> rgba;
  SliceValues values;  // for readings
};

struct OpenedVolumeNews {
  ViewedVolume volume;
  VolumeInfo info;
  ValueHistogram histogram;
  ViewState state;  // to begin with, its view placed
  std::string device;
};

struct SavedNews {
  std::string path;
  std::string command;  // `sluice render ...` that makes it again; of pictures and films
};

struct ProbeNews {
  uint64_t number = 0;              // number of the question
  std::optional<VoxelProbe> found;  // nullopt: nothing is there, or it cannot be read
};

struct PlacedNews {
  uint64_t number = 0;              // see Desk::place()
  std::optional<ViewOptions> view;  // nullopt: it could not be placed
};

// All news since the last call of take(); members without news are empty.
struct News {
  std::unique_ptr<OpenedVolumeNews> opened;
  std::unique_ptr<ViewState> state;       // loaded for the volume that is open
  std::optional<ViewPath> path;           // the path loaded with the volume or the state
  std::unique_ptr<ShownPicture> picture;  // the newest
  std::vector<ShownSlice> slices;
  std::unique_ptr<ShownLook> look;
  std::unique_ptr<RenderReport> report;
  std::optional<PlacedNews> placed;
  std::optional<ProbeNews> probe;
  std::vector<SavedNews> saved;
  std::vector<std::string> failures;  // one line each
  std::vector<std::string> notes;     // such lines that are no failures
  std::vector<std::string> vanished;  // volumes that were asked for and are not there
};

// The work under way at this moment.
struct DeskStatus {
  enum class Doing {
    kNothing,
    kOpening,
    kPreview,
    kPicture,
    kSlices,
    kPlacing,
    kProbe,
    kSaving,
    kFrame
  };
  Doing doing = Doing::kNothing;
  double share = 0;                        // share of opening or drawing that is done, 0 to 1
  bool is_indexing = false;                // opening passes over the voxels
  uint64_t wished = 0;                     // number of the newest wish
  uint64_t completed = 0;                  // number of the newest wish that is drawn whole
  uint64_t failed = 0;                     // number of the newest wish that could not be; 0: none
  int64_t frames = 0, frames_written = 0;  // frames of a film that is being written; 0: none is
};

// Times since the beginning, for wishes that got a picture.
struct DeskTimes {
  uint64_t wishes = 0, previews = 0, complete = 0, cancelled = 0;
  // Seconds from a wish to the first picture that is no older; the last ones.
  std::vector<double> answer_s;
  // Seconds to the first complete picture, for wishes that no other followed.
  std::vector<double> complete_s;
};

// All members may be called from any thread and return at once.
class Desk {
 public:
  virtual ~Desk() = default;
  // Opens a volume in place of the open one, which stays until then, or if opening fails.
  virtual void open(const ViewedVolume& volume, const std::optional<ViewState>& state) = 0;
  // The number of the wish, from 1.
  virtual uint64_t wish(const Wish& wish) = 0;
  // A file of stateText(): the volume that it names is opened with it.
  virtual void loadState(const std::string& path) = 0;
  // The wish as a picture, complete, PNG or EXR as its name ends; its news name the command. It is
  // drawn on the volume of the news that were taken last: before another one is opened, or, if it
  // is asked for too late, not at all, which is a failure in the news.
  virtual void savePicture(const std::string& path, const Wish& wish) = 0;
  // Writes the film frame by frame whenever nothing else is to be done, and replaces a film that is
  // being written. It is of the same volume as a picture would be, and ends if another is opened. A
  // state with the path is written to the same folder (pathFileFor()), and the command of its news
  // uses it. Frames already written stay if the film is cancelled or fails.
  virtual void writeFrames(const FilmWish& film) = 0;
  virtual void cancelFrames() = 0;
  // A small file. It may take the place of a file of this kind; nullopt: of any, for files of the
  // window's own.
  virtual void saveText(const std::string& path, const std::string& text,
                        std::optional<FileKind> kind) = 0;
  // Places the state's view (Renderer::placed()) for a pane of this size. Returns the number that
  // its news will carry. A newer view takes the place of one that is not placed yet, and so does
  // another volume.
  virtual uint64_t place(const ViewState& state, int width, int height) = 0;
  // Asks for the value at a point of the pane (0 to 1, right and down) as the newest wish shows it.
  // Returns the number that its news will carry. A newer question takes the place of one that has
  // no answer.
  virtual uint64_t probe(double right, double down) = 0;
  virtual void wantReport(bool maps) = 0;

  // Returns the news since the last call; of several pictures only the newest is among them.
  virtual News take() = 0;
  virtual DeskStatus status() const = 0;
  virtual DeskTimes times() const = 0;
};

}  // namespace sluice
