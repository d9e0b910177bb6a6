// Two volumes in one picture: the lines about their places.
#include "src/library/opening/place_notes.h"

#include <gmock/gmock.h>

#include <cmath>
#include <memory>
#include <utility>

#include "tests/support/function_source.h"

namespace sluice {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

VolumeLayout layoutIn(const std::string& unit, Vec3d origin = {}) {
  VolumeLayout layout;
  layout.dims = {10, 10, 10};
  layout.origin = origin;
  layout.unit = unit;
  layout.name = "scan";
  return layout;
}

std::vector<std::string> notesOf(const VolumeLayout& over, const VolumeLayout& first) {
  return placeNotes(over, first, "labels");
}

TEST(PlaceNotes, areAboutUnitsThatCannotBeCompared) {
  const Vec3d shift{1, 2, 3};
  const std::string micrometer = "micrometer", millimeter = "millimeter";
  EXPECT_THAT(notesOf(layoutIn("", shift), layoutIn(micrometer)),
              ElementsAre(HasSubstr("labels has no unit of length, and scan has the unit "
                                    "micrometer: ")));
  EXPECT_THAT(notesOf(layoutIn("parsec", shift), layoutIn(millimeter)),
              ElementsAre(HasSubstr("labels has the unit parsec")));
  EXPECT_THAT(notesOf(layoutIn("parsec", shift), layoutIn("")),
              ElementsAre(HasSubstr("scan has no unit of length")));
  EXPECT_THAT(notesOf(layoutIn("", shift), layoutIn(millimeter)), IsEmpty());
  EXPECT_THAT(notesOf(layoutIn("", shift), layoutIn("")), IsEmpty());
  EXPECT_THAT(notesOf(layoutIn("parsec", shift), layoutIn("parsec")), IsEmpty());
  EXPECT_THAT(notesOf(layoutIn(""), layoutIn(micrometer)), IsEmpty());
  VolumeLayout large = layoutIn(millimeter);
  large.spacing = {1e-3, 1e-3, 1e-3};
  EXPECT_THAT(notesOf(large, layoutIn(micrometer, shift)), IsEmpty());
}

TEST(PlaceNotes, areAboutVolumesThatDoNotMeet) {
  EXPECT_THAT(notesOf(layoutIn("", {0, 20, 0}), layoutIn("")),
              ElementsAre("labels: lies beside scan in the world, by the places that the files "
                          "give them"));
  // A volume beside the corner of one that is turned lies in the box around it.
  VolumeLayout turned = layoutIn("", {0, 0, 0});
  const double half = std::sqrt(0.5);
  turned.axes = {{{half, half, 0}, {-half, half, 0}, {0, 0, 1}}};
  turned.dims = {100, 3, 10};
  for (const auto& [over, first] :
       {std::pair{layoutIn("", {50, 5, 0}), turned}, std::pair{turned, layoutIn("", {50, 5, 0})}})
    EXPECT_THAT(placeNotes(over, first, "labels"), ElementsAre(HasSubstr("lies beside")));
  EXPECT_THAT(notesOf(layoutIn("", {50, 45, 0}), turned), IsEmpty());
}

TEST(PlaceNotes, areAboutPlacesThatAreNotUsed) {
  VolumeLayout stage = layoutIn("micrometer");
  stage.place_fault = "a.tif: its PositionX is not used";
  EXPECT_THAT(notesOf(stage, layoutIn("micrometer")), ElementsAre(stage.place_fault));
  EXPECT_THAT(notesOf(layoutIn("micrometer"), stage), ElementsAre(stage.place_fault));
}

TEST(PlaceNotes, tellWhenTheFirstVolumeGivesThePlace) {
  const auto sourceOf = [](VolumeLayout layout) {
    return std::make_unique<FunctionSource>(std::move(layout),
                                            [](int64_t /*t*/, Vec3i at) { return double(at.x); });
  };
  VolumeLayout scan = layoutIn("micrometer", {100, -50, 7}), labels = layoutIn("");
  scan.frame = labels.frame = WorldFrame::kPictureRows;
  labels.tells_place = false;
  std::vector<std::string> notes;
  auto placed = withPlaceOf(scan, sourceOf(labels), "labels", notes);
  EXPECT_EQ(placed->layout().origin, scan.origin);
  EXPECT_THAT(notes,
              ElementsAre("labels: is drawn from the first voxel of scan on, since the place "
                          "of labels is not known"));
  // The other way round, in another unit.
  VolumeLayout stage = scan;
  stage.unit = "nanometer";
  labels.unit = "micrometer";
  labels.name = "picture";
  notes.clear();
  placed = withPlaceOf(labels, sourceOf(stage), "stage", notes);
  EXPECT_EQ(placed->layout().origin, Vec3d{});
  EXPECT_THAT(notes, ElementsAre(HasSubstr("the place of picture is not known")));
  // Both tell a place, or none, or their worlds differ.
  notes.clear();
  VolumeLayout zero = labels, patient = scan;
  zero.tells_place = true;
  patient.frame = WorldFrame::kRas;
  EXPECT_EQ(withPlaceOf(scan, sourceOf(zero), "zero", notes)->layout().origin, Vec3d{});
  EXPECT_EQ(withPlaceOf(labels, sourceOf(labels), "labels", notes)->layout().origin, Vec3d{});
  EXPECT_EQ(withPlaceOf(patient, sourceOf(labels), "labels", notes)->layout().origin, Vec3d{});
  EXPECT_THAT(notes, IsEmpty());
  EXPECT_THAT(placeNotes(labels, labels, "labels"), IsEmpty());
}

}  // namespace
}  // namespace sluice
