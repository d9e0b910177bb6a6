#include "io/dicom/dicom_order.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "io/headers/volume_description.h"
#include "src/base/error.h"

namespace sluice {
namespace {

// Positions are the same within this part of the distance between pixels.
constexpr double kSamePlace = 1e-3;

// A frame, and what its place in the stack follows from.
struct Placed {
  DicomFrame at;
  DicomFunctions functions;
  double along = 0;  // mm along the normal
  DicomLine line;
};

class StackOrder {
 public:
  StackOrder(const std::vector<DicomHeader>& headers, const DicomStack& stack)
      : headers_(headers), stack_(stack), first_(headers[stack.frames[0].file]) {}

  DicomVolume order() {
    list();
    layout_.dims = {stack_.form.columns, stack_.form.rows, 1};
    if (placed_[0].functions.position && placed_[0].functions.directions) {
      sortByPosition();
      dropCopies();
      splitIntoSteps();
      placeByPosition();
    } else {
      sortByNumber();
      placeWithoutPositions();
    }
    if (placed_[0].functions.position && !placed_[0].functions.pixel_spacing)
      note("its slices do not tell the size of their pixels, which are drawn 1 mm wide");
    setValues();
    notePadding();
    checkedVolumeBytes(first_.path, layout_);
    return {std::move(layout_), framesInOrder(), linesInOrder()};
  }

 private:
  const DicomHeader& headerOf(const Placed& p) const { return headers_[p.at.file]; }

  void note(std::string text) {
    layout_.notes.push_back(fmt::format("{}: {}", first_.path, std::move(text)));
  }

  void list() {
    for (const DicomFrame& frame : stack_.frames) {
      const DicomFunctions f = headers_[frame.file].functionsOf(frame.frame);
      placed_.push_back(
          {frame, f, 0, {.slope = f.slope.value_or(1), .intercept = f.intercept.value_or(0)}});
    }
  }

  // Numbers in the order in which they tell frames of one place apart, and frames without one.
  auto numbersOf(const Placed& p) const {
    const DicomHeader& h = headerOf(p);
    return std::tuple(p.functions.time.value_or(0), h.acquisition_number, h.instance_number,
                      p.at.frame, p.at.file);
  }

  void sortByPosition() {
    const auto& [x, y] = *placed_[0].functions.directions;
    const double size = length(cross(x, y));
    // Two directions of length 1 that are at right angles span an area of 1; files round them.
    if (!(size > 0.5 && size < 2))
      fail("{}: the directions of its rows and columns are no two directions", first_.path);
    normal_ = normalized(cross(x, y));
    for (Placed& p : placed_) p.along = dot(*p.functions.position, normal_);
    const auto spacing = placed_[0].functions.pixel_spacing;
    same_ = kSamePlace * (spacing ? std::min(std::abs((*spacing)[0]), std::abs((*spacing)[1])) : 1);
    std::sort(placed_.begin(), placed_.end(),
              [](const Placed& a, const Placed& b) { return a.along < b.along; });
    // Frames of one place next to each other, by their numbers.
    for (size_t begin = 0, end = 0; begin < placed_.size(); begin = end) {
      end = endOfPlace(begin);
      std::sort(placed_.begin() + static_cast<ptrdiff_t>(begin),
                placed_.begin() + static_cast<ptrdiff_t>(end),
                [&](const Placed& a, const Placed& b) { return numbersOf(a) < numbersOf(b); });
    }
  }

  // The first frame behind those in the place of frame `begin`.
  size_t endOfPlace(size_t begin) const {
    size_t end = begin + 1;
    while (end < placed_.size() && placed_[end].along - placed_[begin].along <= same_) ++end;
    return end;
  }

  // The same image in two files is one.
  void dropCopies() {
    std::map<std::pair<std::string, int64_t>, size_t> seen;
    std::vector<Placed> kept;
    size_t copies = 0;
    std::string one;
    for (const Placed& p : placed_) {
      const std::string& instance = headerOf(p).instance;
      // An image has one identifier wherever it is copied to (SOP Instance UID, PS3.3, C.12.1).
      if (!instance.empty() && !seen.try_emplace({instance, p.at.frame}, p.at.file).second) {
        if (copies++ == 0) one = headerOf(p).path;
        continue;
      }
      kept.push_back(p);
    }
    placed_ = std::move(kept);
    if (copies > 0)
      note(fmt::format("{} of its slices are there twice, {} among them; each is read once", copies,
                       one));
  }

  // Every place has as many frames as the first, which are time steps.
  void splitIntoSteps() {
    std::map<size_t, size_t> places_of_size;
    for (size_t begin = 0, end = 0; begin < placed_.size(); begin = end) {
      end = endOfPlace(begin);
      ++places_of_size[end - begin];
    }
    // A missing file makes one place differ from the others: the usual number tells which.
    const auto usual =
        std::max_element(places_of_size.begin(), places_of_size.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    const size_t steps = usual->first;
    for (size_t begin = 0, end = 0; begin < placed_.size(); begin = end) {
      end = endOfPlace(begin);
      if (end - begin != steps) failCrowded(begin, end, steps);
    }
    layout_.time_steps = static_cast<int64_t>(steps);
    layout_.dims.z = static_cast<int64_t>(placed_.size() / steps);
    if (steps > 1 && layout_.dims.z > 1)
      note(fmt::format("each place has {} slices, which are read as time steps", steps));
  }

  [[noreturn]] void failCrowded(size_t begin, size_t end, size_t steps) const {
    const Placed &a = placed_[begin], &b = placed_[end - 1];
    if (steps == 1)
      fail(
          "{}: lies in the same place as {}, {} mm along the stack, expected one slice a place; "
          "leave one of them out",
          headerOf(b).path, headerOf(a).path, a.along);
    fail(
        "{}: {} slices lie in its place, {} mm along the stack, expected {} as in the others, "
        "which "
        "are time steps; a file is missing or one too many",
        headerOf(a).path, end - begin, a.along, steps);
  }

  size_t steps() const { return static_cast<size_t>(layout_.time_steps); }
  const Placed& inPlace(size_t place) const { return placed_[place * steps()]; }

  void placeByPosition() {
    const auto places = static_cast<size_t>(layout_.dims.z);
    const Placed &first = inPlace(0), &last = inPlace(places - 1);
    Vec3d step = normal_ * sliceSpacing(first.functions);
    if (places > 1) {
      std::vector<double> gaps;
      for (size_t i = 1; i < places; ++i) gaps.push_back(inPlace(i).along - inPlace(i - 1).along);
      const double usual = usualGap(gaps);
      const Vec3d whole = *last.functions.position - *first.functions.position;
      step = whole * (usual / (last.along - first.along));
      noteTilt(step);
      noteShifts(step, usual);
    }
    setPlane(first.functions, step);
    setOrigin(first_.path, *first.functions.position, layout_);
    // DICOM's patient coordinates go to the left, to the back and to the head (PS3.3, C.7.6.2.1.1).
    layout_.frame = WorldFrame::kLps;
    layout_.unit = "millimeter";
  }

  // The distance between neighbouring slices: the mean if they are alike, else the median.
  double usualGap(const std::vector<double>& gaps) {
    std::vector<double> sorted = gaps;
    std::sort(sorted.begin(), sorted.end());
    const double median = sorted[sorted.size() / 2];
    constexpr double kAlike = 0.02, kWhole = 0.1;
    double sum = 0;
    for (const double gap : gaps) sum += gap;
    if (sorted.back() - sorted.front() <= kAlike * median)
      return sum / static_cast<double>(gaps.size());
    // A number of any size: one wrong position may be further away than integers count.
    double missing = 0;
    size_t widest = 0;
    bool are_whole = true;
    for (size_t i = 0; i < gaps.size(); ++i) {
      const double times = gaps[i] / median;
      are_whole = are_whole && times > 1 - kWhole &&
                  std::abs(times - std::round(times)) <= kWhole * std::round(times);
      missing += std::max(std::round(times) - 1, 0.0);
      if (gaps[i] > gaps[widest]) widest = i;
    }
    const std::string between = fmt::format("{} and {}", headerOf(inPlace(widest)).path,
                                            headerOf(inPlace(widest + 1)).path);
    if (are_whole && missing > 0)
      note(fmt::format(
          "{:.15g} slices are missing, {} mm apart as the others are, most of them between "
          "{}; the slices "
          "on both sides of a gap become neighbours",
          missing, median, between));
    else
      note(fmt::format(
          "its slices are {} to {} mm apart, the furthest {}; they are drawn {} mm apart",
          sorted.front(), sorted.back(), between, median));
    return median;
  }

  // Slices that are shifted against each other, as with a gantry that is tilted: the step is not
  // along the normal, which the layout's axes tell.
  void noteTilt(Vec3d step) {
    const double cosine = std::clamp(dot(step, normal_) / length(step), -1.0, 1.0);
    const double degrees = std::acos(cosine) * 180 / std::numbers::pi;
    constexpr double kLeastDegrees = 0.1;
    if (degrees >= kLeastDegrees)
      note(
          fmt::format("its gantry was tilted by {:.1f} degrees; the volume is drawn slanted, as it "
                      "was",
                      degrees));
  }

  // Positions beside the straight line from the first to the last.
  void noteShifts(Vec3d step, double usual) {
    const auto spacing = placed_[0].functions.pixel_spacing.value_or(std::array{1.0, 1.0});
    double most = 0;
    size_t where = 0;
    for (size_t i = 0; i < static_cast<size_t>(layout_.dims.z); ++i) {
      const Vec3d from_first = *inPlace(i).functions.position - *inPlace(0).functions.position;
      const Vec3d expected = step * ((inPlace(i).along - inPlace(0).along) / usual);
      const double beside = length(from_first - expected);
      if (beside > most) most = beside, where = i;
    }
    if (most > std::min(std::abs(spacing[0]), std::abs(spacing[1])) / 2)
      note(fmt::format(
          "slice {} lies {} mm beside the straight line of the others; it is drawn on it",
          headerOf(inPlace(where)).path, most));
  }

  void sortByNumber() {
    std::sort(placed_.begin(), placed_.end(),
              [&](const Placed& a, const Placed& b) { return numbersOf(a) < numbersOf(b); });
  }

  void placeWithoutPositions() {
    const auto count = static_cast<int64_t>(placed_.size());
    if (first_.frames_are_times)
      layout_.time_steps = count;
    else
      layout_.dims.z = count;
    const DicomFunctions& f = placed_[0].functions;
    setPlane(f, Vec3d{0, 0, 1} * sliceSpacing(f));
    layout_.frame = WorldFrame::kPictureRows;
    if (f.pixel_spacing) layout_.unit = "millimeter";
    if (layout_.dims.z > 1)
      note(fmt::format(
          "its {} slices tell no positions; they are read in the order of their numbers", count));
  }

  double sliceSpacing(const DicomFunctions& f) const {
    for (const auto& said : {f.slice_spacing, f.thickness})
      if (said && std::abs(*said) > 0) return std::abs(*said);
    return f.pixel_spacing ? (*f.pixel_spacing)[0] : 1;
  }

  // The layout's spacing and axes, along the rows, the columns and the stack.
  void setPlane(const DicomFunctions& f, Vec3d step) {
    const auto spacing = f.pixel_spacing.value_or(std::array{1.0, 1.0});
    const auto directions = f.directions.value_or(std::array{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}});
    // The first number is from row to row, so along y.
    setSteps(first_.path, {directions[0] * spacing[1], directions[1] * spacing[0], step}, layout_);
  }

  // Keeps stored numbers if one line makes values of all of them; else values become integers of 16
  // bits if they fit, or floats.
  void setValues() {
    layout_.type = storedDicomType(stack_.form);
    const DicomLine& line = placed_[0].line;
    // CT series have one slope and intercept; those of PET differ from slice to slice.
    is_one_line_ = std::all_of(placed_.begin(), placed_.end(),
                               [&](const Placed& p) { return p.line == line; });
    for (const Placed& p : placed_)
      setValueScale(headerOf(p).path, p.line.slope, p.line.intercept, layout_);
    if (is_one_line_) return;
    layout_.value_scale = 1;
    layout_.value_offset = 0;
    const DicomRange stored = storedDicomRange(stack_.form);
    const auto fits = [&](const Placed& p) {
      const auto is_whole = [](double value) { return value == std::floor(value); };
      const double a = p.line.slope * stored.lo + p.line.intercept;
      const double b = p.line.slope * stored.hi + p.line.intercept;
      return !stack_.form.is_float && is_whole(p.line.slope) && is_whole(p.line.intercept) &&
             std::min(a, b) >= INT16_MIN && std::max(a, b) <= INT16_MAX;
    };
    layout_.type =
        std::all_of(placed_.begin(), placed_.end(), fits) ? VoxelType::kI16 : VoxelType::kF32;
  }

  // Pixels around the image of a round detector, for example.
  void notePadding() {
    const Placed& slice = placed_[0];
    const DicomHeader& h = headerOf(slice);
    if (!h.padding) return;
    const auto value = [&](int64_t stored) {
      return slice.line.slope * static_cast<double>(stored) + slice.line.intercept;
    };
    const bool is_range = h.padding_limit && *h.padding_limit != *h.padding;
    const double at = value(*h.padding);
    const std::string values =
        is_range ? fmt::format("values {:g} to {:g}", std::min(at, value(*h.padding_limit)),
                               std::max(at, value(*h.padding_limit)))
                 : fmt::format("value {:g}", at);
    note(
        fmt::format("voxels of the {} stand for padding around the image (PixelPaddingValue); "
                    "sluice draws them as values",
                    values));
  }

  // Calls f for each slice of each time step.
  template <class F>
  void inOrder(F f) const {
    const size_t slices = placed_.size() / steps();
    for (size_t t = 0; t < steps(); ++t)
      for (size_t z = 0; z < slices; ++z) f(placed_[z * steps() + t]);
  }
  std::vector<DicomFrame> framesInOrder() const {
    std::vector<DicomFrame> frames;
    inOrder([&](const Placed& p) { frames.push_back(p.at); });
    return frames;
  }
  std::vector<DicomLine> linesInOrder() const {
    std::vector<DicomLine> lines;
    if (!is_one_line_) inOrder([&](const Placed& p) { lines.push_back(p.line); });
    return lines;
  }

  const std::vector<DicomHeader>& headers_;
  const DicomStack& stack_;
  const DicomHeader& first_;
  std::vector<Placed> placed_;
  VolumeLayout layout_;
  Vec3d normal_{0, 0, 1};
  double same_ = 0;  // mm
  bool is_one_line_ = true;
};

}  // namespace

DicomVolume orderDicomStack(const std::vector<DicomHeader>& headers, const DicomStack& stack) {
  return StackOrder(headers, stack).order();
}

}  // namespace sluice
