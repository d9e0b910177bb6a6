#include "src/library/opening/place_notes.h"

#include <fmt/format.h>

#include <utility>

#include "io/files/length_unit.h"
#include "io/relabelled.h"
#include "src/base/sources/place_fault.h"
#include "src/library/drawing/scene/shared_world.h"

namespace sluice {
namespace {

// Both directions, since the box around a turned volume is larger than the volume.
bool areApart(const VolumeLayout& a, const VolumeLayout& b) {
  return cropOn(a, b, boxOf(b.dims)) == Box3{} || cropOn(b, a, boxOf(a.dims)) == Box3{};
}

// Whether lengths of both can be compared. A file without a unit most likely means millimeters, as
// scanners do.
bool haveComparedUnits(const VolumeLayout& a, const VolumeLayout& b) {
  const auto usual = [](const std::string& unit) { return unit.empty() ? "millimeter" : unit; };
  return (metersOf(a.unit) && metersOf(b.unit)) || usual(a.unit) == usual(b.unit);
}

std::string unitOf(const VolumeLayout& layout, const std::string& name) {
  return layout.unit.empty() ? fmt::format("{} has no unit of length", name)
                             : fmt::format("{} has the unit {}", name, layout.unit);
}

}  // namespace

std::vector<std::string> placeNotes(const VolumeLayout& over, const VolumeLayout& first,
                                    const std::string& name) {
  std::vector<std::string> notes;
  // The numbers of both headers agree: one was made from the other one.
  if (!haveComparedUnits(over, first) && !isSameGrid(over, first))
    notes.push_back(fmt::format(
        "{}, and {}: their lengths are taken to be in one unit, so that sizes and places may be "
        "wrong; write the unit into the header",
        unitOf(over, name), unitOf(first, first.name)));
  if (areApart(over, first))
    notes.push_back(
        fmt::format("{}: lies beside {} in the world, by the places that the files give them", name,
                    first.name));
  for (const VolumeLayout* layout : {&over, &first})
    if (!layout->place_fault.empty()) notes.push_back(layout->place_fault);
  return notes;
}

std::unique_ptr<VolumeSource> withPlaceOf(const VolumeLayout& first,
                                          std::unique_ptr<VolumeSource> over,
                                          const std::string& name,
                                          std::vector<std::string>& notes) {
  const VolumeLayout& own = over->layout();
  const bool is_microscopy =
      own.frame == WorldFrame::kPictureRows && first.frame == WorldFrame::kPictureRows;
  // One of two pictures without a place in space: the unplaced one is taken to begin where the
  // other one does.
  if (!is_microscopy || isUnplaced(own) == isUnplaced(first)) return over;
  const Vec3d origin = first.origin / worldScale(own, first);
  if (own.origin == origin) return over;
  notes.push_back(
      fmt::format("{}: is drawn from the first voxel of {} on, since the place of {} is "
                  "not known",
                  name, first.name, isUnplaced(own) ? name : first.name));
  return placedAt(std::move(over), origin);
}

}  // namespace sluice
