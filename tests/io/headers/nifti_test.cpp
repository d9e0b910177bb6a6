#include "io/headers/nifti/nifti.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

#include "io/headers/nifti/nifti_header.h"
#include "tests/io/headers/volume_files.h"

namespace sluice::nifti_test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr Vec3i kDims{5, 4, 3};
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A header under construction; the offsets are from the standard's nifti1.h and nifti2.h.
class HeaderBytes {
 public:
  explicit HeaderBytes(size_t size) : bytes_(size, '\0') {}

  template <class T>
  HeaderBytes& set(size_t offset, T value) {
    std::memcpy(bytes_.data() + offset, &value, sizeof(T));
    return *this;
  }
  HeaderBytes& text(size_t offset, std::string_view value) {
    std::copy(value.begin(), value.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// NIfTI-1, 5 x 4 x 3 i16, single file, pixdim 1 2 3.
HeaderBytes plainHeader() {
  HeaderBytes h(352);
  h.set<int32_t>(0, 348).text(344, "n+1");
  const std::array<int16_t, 8> dim = {3, 5, 4, 3, 1, 1, 1, 1};
  for (size_t i = 0; i < 8; ++i) h.set<int16_t>(40 + 2 * i, dim[i]);
  h.set<int16_t>(70, 4).set<int16_t>(72, 16);
  for (size_t i = 0; i < 4; ++i) h.set<float>(76 + 4 * i, i == 0 ? 1.0F : static_cast<float>(i));
  return h.set<float>(108, 352);
}

NiftiHeader parse(const std::string& bytes) {
  return parseNiftiHeader(std::as_bytes(std::span(bytes)), "v.nii");
}
VolumeLayout layoutOf(const HeaderBytes& h) {
  return parse(h.bytes()).description.layout;
}

void expectNear(Vec3d actual, Vec3d expected, double tolerance = 1e-6) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(actual[axis], expected[axis], tolerance) << axis;
}

Vec3d worldOf(const VolumeLayout& layout, Vec3d index) {
  Vec3d world = layout.origin;
  for (int axis = 0; axis < 3; ++axis)
    world = world + layout.axes[static_cast<size_t>(axis)] * (layout.spacing[axis] * index[axis]);
  return world;
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

// ---- Files -----------------------------------------------------------------------------------

TEST(NiftiTest, readsASingleFileOfEitherByteOrder) {
  const TempFolder folder;
  const std::string voxels = knownVoxels(VoxelType::kI16, kDims);
  expectKnownVolume(*openNifti(folder.write("a.nii", plainHeader().bytes() + voxels)),
                    VoxelType::kI16, kDims);
}

TEST(NiftiTest, aFileTooSmallShowsTheArithmetic) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { openNifti(folder.write("a.nii", plainHeader().bytes() + "1234567")); }),
              HasSubstr("5 x 4 x 3 x 2 bytes (i16) + 352 skipped = 472 bytes expected, 359 found"));
}

TEST(NiftiTest, aTinyCompressedFileThatClaimsMuchIsTurnedAwayAtOnce) {
  SLUICE_NEEDS("gzip", "gzip --version");
  const TempFolder folder;
  HeaderBytes h = plainHeader();
  for (size_t i = 1; i < 4; ++i) h.set<int16_t>(40 + 2 * i, 32767);
  ASSERT_TRUE(runs("gzip " + folder.write("a.nii", h.bytes() + "voxels").string()));
  EXPECT_THAT(errorOf([&] { openNifti(folder / "a.nii.gz"); }),
              HasSubstr("bytes of encoded data can hold"));
}

TEST(NiftiTest, aPairWithoutItsImageIsAnError) {
  const TempFolder folder;
  const auto header = folder.write("a.hdr", plainHeader().text(344, "ni1").bytes());
  EXPECT_THAT(errorOf([&] { openNifti(header); }), HasSubstr("a.img with its voxels is missing"));
  EXPECT_THAT(errorOf([&] { openNifti(folder / "b.img"); }), HasSubstr("b.hdr: cannot be opened"));
  const auto odd = folder.write("odd", plainHeader().text(344, "ni1").bytes());
  EXPECT_THAT(errorOf([&] { openNifti(odd); }), HasSubstr("ends in .hdr"));
}

// ---- Against nibabel and nifti_tool ----------------------------------------------------------

constexpr std::array<const char*, 8> kKinds = {"u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"};

// An oblique, anisotropic and sheared-free affine; a mirrored one.
constexpr const char* kAffines = R"(
import nibabel as nib
c, s = np.cos(0.3), np.sin(0.3)
turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) @ np.array([[1.0, 0, 0], [0, s, -c], [0, c, s]])
affines = {'plain': np.eye(4), 'oblique': np.eye(4), 'mirrored': np.eye(4)}
affines['oblique'][:3, :3] = turn @ np.diag([1.0, 2, 0.5])
affines['mirrored'][:3, :3] = turn @ np.diag([-1.5, 2, 3])
for m in affines.values(): m[:3, 3] = [-7, 8, 90]
)";

TEST(NiftiPeerTest, readsTheUnitThatNibabelWrites) {
  SLUICE_NEEDS_MODULE("nibabel");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, R"(
import nibabel as nib
for kind in [nib.Nifti1Image, nib.Nifti2Image]:
    for unit in ['unknown', 'meter', 'mm', 'micron']:
        image = kind(known('u1', 5, 4, 3), np.eye(4))
        image.header.set_xyzt_units(unit, 'msec')
        nib.save(image, folder + unit + ('1' if kind is nib.Nifti1Image else '2') + '.nii')
)")) << readFile(folder / "script.log");
  for (const auto& [file, unit] : {std::pair{"unknown", ""},
                                   {"meter", "meter"},
                                   {"mm", "millimeter"},
                                   {"micron", "micrometer"}})
    for (const char* version : {"1", "2"})
      EXPECT_EQ(openNifti(folder / (std::string(file) + version + ".nii"))->layout().unit, unit);
}

TEST(NiftiPeerTest, readsEveryTypeVersionByteOrderAndPackingThatNibabelWrites) {
  SLUICE_NEEDS_MODULE("nibabel");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, std::string(kAffines) + R"(
for kind in ['u1', 'i1', 'u2', 'i2', 'u4', 'i4', 'f4', 'f8']:
    for order in '<>':
        data = known(kind, 5, 4, 3, 2)
        for version, single, pair in [(1, nib.Nifti1Image, nib.Nifti1Pair), (2, nib.Nifti2Image, nib.Nifti2Pair)]:
            stem = folder + kind + ('b' if order == '>' else 'l') + str(version)
            for cls, ends in [(single, ['.nii', '.nii.gz']), (pair, ['.img', 'z.img.gz'])]:
                header = cls.header_class(endianness=order)
                header.set_data_dtype(np.dtype(kind).newbyteorder(order))
                image = cls(data, affines['oblique'], header)
                for end in ends:
                    nib.save(image, stem + end)
)")) << readFile(folder / "script.log");
  for (size_t i = 0; i < kKinds.size(); ++i)
    for (const char* variant : {"l1", "l2", "b1", "b2"})
      for (const char* end : {".nii", ".nii.gz", ".hdr", ".img", "z.hdr.gz", "z.img.gz"}) {
        const std::string file = std::string(kKinds[i]) + variant + end;
        SCOPED_TRACE(file);
        const auto source = openNifti(folder / file);
        expectKnownVolume(*source, static_cast<VoxelType>(i), kDims, 2);
        expectNear(source->layout().spacing, {1, 2, 0.5});
      }
}

// Fills `folder` with the affine that the peer computes for each file, a line a row.
void expectAffine(const TempFolder& folder, const std::string& stem) {
  std::istringstream numbers(readFile(folder / (stem + ".txt")));
  std::array<double, 16> m{};
  for (double& number : m) ASSERT_TRUE(numbers >> number) << stem;
  const VolumeLayout layout = openNifti(folder / (stem + ".nii"))->layout();
  for (const Vec3d index : {Vec3d{0, 0, 0}, Vec3d{4, 0, 0}, Vec3d{0, 3, 0}, Vec3d{1, 2, 3}}) {
    Vec3d expected;
    for (int row = 0; row < 3; ++row) {
      const size_t at = static_cast<size_t>(row) * 4;
      expected[row] = m[at] * index.x + m[at + 1] * index.y + m[at + 2] * index.z + m[at + 3];
    }
    SCOPED_TRACE(stem);
    expectNear(worldOf(layout, index), expected, 2e-5);
  }
}

TEST(NiftiPeerTest, placesVoxelsInTheWorldAsNibabelDoes) {
  SLUICE_NEEDS_MODULE("nibabel");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, std::string(kAffines) + R"(
for name, affine in affines.items():
    for form in ['s', 'q', 'both']:
        image = nib.Nifti1Image(known('u1', 5, 4, 3), affine)
        image.set_sform(affine, 4 if form != 'q' else 0)
        image.set_qform(affine if form == 'q' else np.eye(4), 1 if form != 's' else 0)
        stem = folder + name + form
        nib.save(image, stem + '.nii')
        np.savetxt(stem + '.txt', nib.load(stem + '.nii').affine)
)")) << readFile(folder / "script.log");
  for (const char* name : {"plain", "oblique", "mirrored"})
    for (const char* form : {"s", "q", "both"}) expectAffine(folder, std::string(name) + form);
}

TEST(NiftiPeerTest, scalesAsNibabelDoes) {
  SLUICE_NEEDS_MODULE("nibabel");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, R"(
import nibabel as nib
image = nib.Nifti1Image(known('i2', 5, 4, 3), np.eye(4))
image.header.set_slope_inter(0.25, -3)
nib.save(image, folder + 'a.nii')
print('value', nib.load(folder + 'a.nii').get_fdata()[4, 3, 2])
)"));
  const auto source = openNifti(folder / "a.nii");
  const std::vector<std::byte> corner = readBox(*source, 0, {{4, 3, 2}, {5, 4, 3}});
  int16_t stored = 0;
  std::memcpy(&stored, corner.data(), sizeof(stored));
  const VolumeLayout& layout = source->layout();
  std::istringstream log(readFile(folder / "script.log"));
  std::string word;
  double expected = 0;
  ASSERT_TRUE(log >> word >> expected);
  EXPECT_NEAR(stored * layout.value_scale + layout.value_offset, expected, 1e-9);
}

TEST(NiftiPeerTest, readsWhatNiftiToolMakes) {
  SLUICE_NEEDS("nifti_tool", "nifti_tool -ver");
  const TempFolder folder;
  const std::string out = (folder / "made.nii").string();
  ASSERT_TRUE(runs("nifti_tool -make_im -prefix " + out +
                   " -new_dim 3 5 4 3 1 1 1 1 "
                   "-new_datatype 16"));
  ASSERT_TRUE(runs("nifti_tool -mod_hdr -overwrite -infiles " + out +
                   " -mod_field pixdim '-1 2 3 4 1 1 1 1' -mod_field qform_code 1"
                   " -mod_field qoffset_x 11 -mod_field scl_slope 2"));
  const auto source = openNifti(out);
  EXPECT_TRUE(source->layout().dims == kDims);
  EXPECT_EQ(source->layout().type, VoxelType::kF32);
  EXPECT_EQ(readAll(*source), std::string(240, '\0'));
  expectNear(source->layout().spacing, {2, 3, 4});
  expectNear(source->layout().axes[2], {0, 0, -1});
  expectNear(source->layout().origin, {11, 0, 0});
  EXPECT_EQ(source->layout().value_scale, 2);
}

TEST(NiftiPeerTest, readsWhatVtkWrites) {
  SLUICE_NEEDS_MODULE("vtk");
  const TempFolder folder;
  ASSERT_TRUE(runsPython(folder, R"(
import vtk
from vtk.util.numpy_support import numpy_to_vtk
image = vtk.vtkImageData()
image.SetDimensions(5, 4, 3)
image.SetSpacing(1, 2, 0.5)
image.GetPointData().SetScalars(numpy_to_vtk(known('u2', 5, 4, 3).ravel(order='F'), deep=True))
for name in ['a.nii', 'b.nii.gz', 'c.hdr']:
    writer = vtk.vtkNIFTIImageWriter()
    writer.SetInputData(image)
    writer.SetFileName(folder + name)
    writer.Write()
)")) << readFile(folder / "script.log");
  for (const char* name : {"a.nii", "b.nii.gz", "c.hdr"}) {
    SCOPED_TRACE(name);
    const auto source = openNifti(folder / name);
    expectKnownVolume(*source, VoxelType::kU16, kDims);
    expectNear(source->layout().spacing, {1, 2, 0.5});
  }
}

}  // namespace
}  // namespace sluice::nifti_test
