#include "io/headers/nifti/nifti_header.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <span>
#include <string>

#include "tests/io/headers/nifti_headers.h"
#include "tests/io/headers/volume_files.h"

namespace sluice::nifti_test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

NiftiHeader parse(const std::string& bytes) {
  return parseNiftiHeader(std::as_bytes(std::span(bytes)), "v.nii");
}
VolumeLayout layoutOf(const HeaderBytes& h) {
  return parse(h.bytes()).description.layout;
}

TEST(NiftiHeaderTest, readsAPlainHeader) {
  const NiftiHeader header = parse(plainHeader().bytes());
  const VolumeDescription& d = header.description;
  EXPECT_FALSE(header.pair);
  EXPECT_TRUE(d.layout.dims == kDims);
  EXPECT_EQ(d.layout.type, VoxelType::kI16);
  EXPECT_EQ(d.byte_order, std::endian::native);
  EXPECT_EQ(d.byte_skip, 352);
  expectNear(d.layout.spacing, {1, 2, 3});
  EXPECT_EQ(d.layout.value_scale, 1);
}

TEST(NiftiHeaderTest, timesAreInTheirUnitOfXyztUnits) {
  const auto timesOf = [](float step, char units, int16_t steps = 7) {
    HeaderBytes h = plainHeader();
    h.set<int16_t>(40, 4).set<int16_t>(48, steps).set<float>(92, step).set<float>(136, 1.5F);
    return parse(h.set<char>(123, units).bytes()).times;
  };
  EXPECT_EQ(timesOf(2.5F, 2 + 8), (TimeAxis{2.5, 1.5, "second"}));
  EXPECT_EQ(timesOf(2.5F, 2 + 16), (TimeAxis{2.5, 1.5, "millisecond"}));
  EXPECT_EQ(timesOf(2.5F, 24), (TimeAxis{2.5, 1.5, "microsecond"}));
  EXPECT_EQ(timesOf(2.5F, 2), (TimeAxis{2.5, 1.5, ""}));
  EXPECT_EQ(timesOf(2.5F, 32), std::nullopt) << "hertz";
  EXPECT_EQ(timesOf(2.5F, -1), std::nullopt);
  EXPECT_EQ(timesOf(2.5F, 8, 1), std::nullopt) << "one step";
  EXPECT_EQ(timesOf(0, 8), std::nullopt) << "not known";
}

// The unit and the time of the first step are kept.
TEST(NiftiHeaderTest, timesThatAreNoneAreWarnedOf) {
  const auto parsed = [](float step, float start) {
    HeaderBytes h = plainHeader();
    h.set<int16_t>(40, 4).set<int16_t>(48, 7).set<float>(92, step).set<float>(136, start);
    return parse(h.set<char>(123, 2 + 16).bytes());
  };
  const auto notesOf = [](const NiftiHeader& header) {
    std::string all;
    for (const std::string& note : header.description.layout.notes) all += note + "\n";
    return all;
  };
  for (const float none : {-2.0F, kNan, kInfinity}) {
    const NiftiHeader header = parsed(none, 1.5F);
    EXPECT_EQ(header.times, (TimeAxis{1, 1.5, "millisecond"})) << none;
    EXPECT_NE(notesOf(header).find(
                  fmt::format("pixdim[4] is {}; a time between steps of 1 millisecond", none)),
              std::string::npos)
        << notesOf(header);
  }
  const NiftiHeader header = parsed(2, kNan);
  EXPECT_EQ(header.times, (TimeAxis{2, 0, "millisecond"}));
  EXPECT_NE(notesOf(header).find("toffset is nan; a time of the first step of 0 millisecond"),
            std::string::npos)
      << notesOf(header);
  EXPECT_EQ(notesOf(parsed(2, 0)).find("pixdim[4]"), std::string::npos);
}

TEST(NiftiHeaderTest, missingSizesAndScalesMeanOne) {
  HeaderBytes h = plainHeader();
  h.set<int16_t>(40, 2).set<int16_t>(46, -9).set<float>(84, 0).set<float>(88, -2);
  h.set<float>(112, kNan).set<float>(116, kInfinity).set<int16_t>(72, 0);
  const VolumeLayout layout = layoutOf(h);
  EXPECT_TRUE(layout.dims == (Vec3i{5, 4, 1}));
  expectNear(layout.spacing, {1, 1, 2});
  EXPECT_EQ(layout.value_scale, 1);
}

TEST(NiftiHeaderTest, aFieldWithoutAMeaningIsNamed) {
  const auto notesOf = [](HeaderBytes h) { return layoutOf(h.set<int16_t>(252, 1)).notes; };
  EXPECT_THAT(notesOf(plainHeader()), testing::IsEmpty());
  EXPECT_THAT(notesOf(plainHeader().set<float>(76, -1)), testing::IsEmpty());
  EXPECT_THAT(notesOf(plainHeader().set<char>(123, 2 + 8)), testing::IsEmpty());
  EXPECT_THAT(notesOf(plainHeader().set<float>(112, kNan)), testing::IsEmpty());
  const std::vector<std::pair<HeaderBytes, std::string>> slips = {
      {plainHeader().set<float>(80, 0), "v.nii: pixdim[1] is 0; a voxel size of 1 is used"},
      {plainHeader().set<float>(88, -2), "v.nii: pixdim[3] is -2; only its magnitude is used"},
      {plainHeader().set<float>(76, 7), "v.nii: pixdim[0] is 7; only its sign is used"},
      {plainHeader().set<char>(123, 99), "v.nii: xyzt_units is 99; it names no unit of length"},
      {plainHeader().set<char>(123, 5), "v.nii: xyzt_units is 5; it names no unit of length"},
      {plainHeader().set<int16_t>(254, -3),
       "v.nii: sform_code is -3; from 0 to 5 expected, it is "
       "used as 0"}};
  for (const auto& [header, note] : slips) EXPECT_THAT(notesOf(header), testing::ElementsAre(note));
  EXPECT_EQ(layoutOf(plainHeader().set<char>(123, 99)).unit, "");
  EXPECT_THAT(layoutOf(plainHeader().set<int16_t>(252, 9)).notes,
              testing::ElementsAre("v.nii: qform_code is 9; it is used as 1"));
}

TEST(NiftiHeaderTest, scalingIsTakenOver) {
  const VolumeLayout layout = layoutOf(plainHeader().set<float>(112, -0.5F).set<float>(116, 8));
  EXPECT_EQ(layout.value_scale, -0.5);
  EXPECT_EQ(layout.value_offset, 8);
}

TEST(NiftiHeaderTest, sformComesBeforeQform) {
  HeaderBytes h = plainHeader();
  const std::array<float, 12> rows = {0, -2, 0, 10, 3, 0, 0, 20, 0, 0, 4, 30};
  for (size_t i = 0; i < 12; ++i) h.set<float>(280 + 4 * i, rows[i]);
  h.set<int16_t>(252, 1).set<int16_t>(254, 4).set<float>(256, 77);
  const VolumeLayout layout = layoutOf(h);
  expectNear(layout.spacing, {3, 2, 4});
  expectNear(layout.axes[0], {0, 1, 0});
  expectNear(layout.axes[1], {-1, 0, 0});
  expectNear(layout.origin, {10, 20, 30});
}

TEST(NiftiHeaderTest, theWorldIsRightAnteriorSuperiorAndANoteSaysWhereThatIsAGuess) {
  EXPECT_EQ(layoutOf(plainHeader()).frame, WorldFrame::kRas);
  EXPECT_THAT(layoutOf(plainHeader()).notes, testing::ElementsAre(HasSubstr("no qform, no sform")));
  EXPECT_THAT(layoutOf(plainHeader().set<int16_t>(252, 1)).notes, testing::IsEmpty());
}

TEST(NiftiHeaderTest, qformTurnsAndItsHandednessMirrors) {
  // A quarter turn about z: x goes to y.
  HeaderBytes h = plainHeader();
  h.set<int16_t>(252, 1).set<float>(264, std::sqrt(0.5F)).set<float>(268, 9);
  expectNear(layoutOf(h).axes[0], {0, 1, 0});
  expectNear(layoutOf(h).axes[1], {-1, 0, 0});
  expectNear(layoutOf(h).axes[2], {0, 0, 1});
  expectNear(layoutOf(h).origin, {9, 0, 0});
  h.set<float>(76, -1);
  expectNear(layoutOf(h).axes[2], {0, 0, -1});
  expectNear(layoutOf(h).spacing, {1, 2, 3});
}

TEST(NiftiHeaderTest, eachFieldThatIsWrongIsAnError) {
  struct Case {
    HeaderBytes header;
    const char* expected;
  };
  const auto plain = plainHeader;
  const Case cases[] = {
      {plain().set<int32_t>(0, 347), "sizeof_hdr is 347, 348 or 540 expected"},
      {plain().text(344, "n+7"), "not its magic"},
      {plain().text(344, std::string_view("\0\0\0", 3)), "ANALYZE files are not read"},
      {plain().set<int16_t>(40, 0), "dim[0] is 0"},
      {plain().set<int16_t>(40, 8), "dim[0] is 8"},
      {plain().set<int16_t>(40, -3), "dim[0] is -3"},
      {plain().set<int16_t>(42, 0), "dim[1] is 0"},
      {plain().set<int16_t>(46, -4), "dim[3] is -4"},
      {plain().set<int16_t>(40, 5).set<int16_t>(50, 3), "dim[5] is 3; only volumes of one value"},
      {plain().set<int16_t>(70, 128), "datatype 128 is not read"},
      {plain().set<int16_t>(70, 32), "datatype 32 is not read"},
      {plain().set<int16_t>(70, 1024), "datatype 1024 is not read"},
      {plain().set<int16_t>(70, 0), "datatype 0 is not read"},
      {plain().set<int16_t>(70, -1), "datatype -1 is not read"},
      {plain().set<int16_t>(72, 8), "datatype 4 (i16) has 16 bits per voxel, but bitpix is 8"},
      {plain().set<float>(108, 0), "vox_offset is 0, a whole number from 352 on"},
      {plain().set<float>(108, -352), "vox_offset is -352"},
      {plain().set<float>(108, 352.5F), "vox_offset is 352.5"},
      {plain().set<float>(108, kNan), "vox_offset is nan"},
      {plain().set<float>(108, kInfinity), "vox_offset is inf"},
      {plain().set<float>(108, 1e30F), "vox_offset is 1"},
      {plain().set<float>(80, kNan), "spacing of axis 0"},
      {plain().set<float>(84, kInfinity), "spacing of axis 1"},
      {plain().set<float>(88, 1e35F), "spacing of axis 2"},
      {plain().set<float>(88, 1e-35F), "spacing of axis 2"},
      {plain().set<float>(112, kInfinity), "* inf + 0: expected"},
      {plain().set<float>(112, 1).set<float>(116, kNan), "* 1 + nan: expected"},
      {plain().set<int16_t>(252, 1).set<float>(256, 1.2F), "quaternion (1.2"},
      {plain().set<int16_t>(252, 1).set<float>(260, kNan), "quaternion"},
      {plain().set<int16_t>(252, 1).set<float>(272, kNan), "origin (0, nan, 0)"},
      {plain().set<int16_t>(254, 1), "spacing of axis 0"},
      {plain().set<int16_t>(254, 1).set<float>(280, 1).set<float>(284, 1).set<float>(320, 1),
       "lie in one plane"},
      {plain().set<int16_t>(254, 1).set<float>(280, kNan), "spacing of axis 0"},
  };
  for (const Case& c : cases) {
    const std::string line = errorOf([&] { parse(c.header.bytes()); });
    EXPECT_THAT(line, StartsWith("v.nii: "));
    EXPECT_THAT(line, HasSubstr(c.expected));
  }
}

TEST(NiftiHeaderTest, dimensionsThatOverflowAreAnError) {
  HeaderBytes h(544);
  h.set<int32_t>(0, 540).text(4, std::string_view("n+2\0\r\n\032\n", 8));
  h.set<int16_t>(12, 2).set<int16_t>(14, 8).set<int64_t>(168, 544);
  h.set<int64_t>(16, 3);
  for (size_t i = 1; i < 4; ++i) h.set<int64_t>(16 + 8 * i, int64_t{1} << 31);
  EXPECT_THAT(errorOf([&] { parse(h.bytes()); }), HasSubstr("do not fit 2^62 bytes"));
  h.set<int64_t>(24, std::numeric_limits<int64_t>::min());
  EXPECT_THAT(errorOf([&] { parse(h.bytes()); }), HasSubstr("dim[1] is -9223372036854775808"));
}

TEST(NiftiHeaderTest, everyTruncationIsAnError) {
  const std::string whole = plainHeader().bytes();
  for (size_t length = 0; length < 348; ++length)
    EXPECT_THAT(errorOf([&] { parse(whole.substr(0, length)); }), HasSubstr("no NIfTI file"));
  HeaderBytes second(540);
  second.set<int32_t>(0, 540);
  EXPECT_THAT(errorOf([&] { parse(second.bytes().substr(0, 539)); }),
              HasSubstr("539 bytes, the NIfTI-2 header alone has 540"));
}

}  // namespace
}  // namespace sluice::nifti_test
