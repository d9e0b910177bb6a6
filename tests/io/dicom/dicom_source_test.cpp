// DICOM series as pydicom writes and GDCM compresses them, and the samples of pydicom's own tests.
#include <gmock/gmock.h>

#include <cstdlib>

#include "io/dicom/dicom_source.h"
#include "io/open_volume.h"
#include "tests/io/python_volumes.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A folder of make_dicom.py.
struct DicomCase {
  static constexpr const char* kScript = "make_dicom.py";
  static constexpr const char* kModules = "numpy, pydicom";

  std::string name;
  Vec3i dims;
  int64_t steps = 1;
  std::string type;
  Vec3d spacing;
  std::string unit;
  double scale = 1, offset = 0;

  friend std::istream& operator>>(std::istream& line, DicomCase& c) {
    return line >> c.name >> c.dims.x >> c.dims.y >> c.dims.z >> c.steps >> c.type >> c.spacing.x >>
           c.spacing.y >> c.spacing.z >> c.unit >> c.scale >> c.offset;
  }
};

// Frames of these need the module.
bool isDecodedByGdcm(const std::string& name) {
  return name.starts_with("j");
}
bool hasDecoder() {
  return fs::exists(SLUICE_BUILD_DIR "/sluice_dicom.so");
}

class DicomSeries : public PythonVolumesTest<DicomCase> {
 protected:
  static std::unique_ptr<VolumeSource> open(const std::string& name,
                                            const OpenOptions& options = {}) {
    return openVolume(pathOf(name).string(), options);
  }
  static std::vector<std::string> notesOf(const std::string& name) {
    return open(name)->layout().notes;
  }
};

TEST_F(DicomSeries, haveTheVoxelsThatWereWritten) {
  ASSERT_GE(cases_.size(), 25U);
  for (const DicomCase& c : cases_) {
    if (isDecodedByGdcm(c.name) && !hasDecoder()) continue;
    SCOPED_TRACE(c.name);
    const auto source = open(c.name);
    const VolumeLayout& layout = source->layout();
    EXPECT_EQ(layout.dims, c.dims);
    EXPECT_EQ(layout.time_steps, c.steps);
    EXPECT_EQ(name(layout.type), c.type);
    EXPECT_EQ(layout.unit, c.unit == "-" ? "" : c.unit);
    EXPECT_EQ(layout.value_scale, c.scale);
    EXPECT_EQ(layout.value_offset, c.offset);
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(layout.spacing[a], c.spacing[a], 1e-6);
    EXPECT_TRUE(allSteps(*source) == voxelsOf(c.name));
    expectBoxesAreParts(*source, voxelsOf(c.name));
  }
}

TEST_F(DicomSeries, areDecodedWithinTheBytesThatAreHeld) {
  for (const DicomCase& c : cases_) {
    if (isDecodedByGdcm(c.name) && !hasDecoder()) continue;
    const auto source = open(c.name);
    source->holdAtMost(0);
    EXPECT_TRUE(allSteps(*source) == voxelsOf(c.name)) << c.name;
  }
}

TEST_F(DicomSeries, lieInThePatientAsTheirPositionsSay) {
  const auto source = open("ct");
  EXPECT_EQ(source->layout().frame, WorldFrame::kLps);
  EXPECT_EQ(source->layout().origin, (Vec3d{-10, 20, 30}));
  EXPECT_EQ(source->layout().axes[2], (Vec3d{0, 0, 1}));
  EXPECT_THAT(source->layout().notes, IsEmpty());
  EXPECT_EQ(open("enhanced")->layout().origin, (Vec3d{-10, 20, 30}));
  EXPECT_EQ(open("dose")->layout().origin, (Vec3d{-10, 20, 30}));
  const auto tilted = open("tilt");
  EXPECT_NEAR(tilted->layout().axes[2].y / tilted->layout().axes[2].z, 0.2, 1e-6);
  EXPECT_THAT(tilted->layout().notes, ElementsAre(HasSubstr("tilted by 11.3 degrees")));
}

TEST_F(DicomSeries, sayWhatIsMissingOrTwiceThere) {
  EXPECT_THAT(notesOf("missing"), ElementsAre(HasSubstr("2 slices are missing")));
  EXPECT_THAT(notesOf("far"), ElementsAre(HasSubstr("4e+24 slices are missing")));
  EXPECT_THAT(notesOf("copies"),
              ElementsAre(AllOf(HasSubstr("1 of its slices are there twice"), HasSubstr("Z003"))));
  EXPECT_THAT(notesOf("times"), ElementsAre(HasSubstr("3 slices, which are read as time steps")));
  EXPECT_THAT(notesOf("no-positions"), ElementsAre(HasSubstr("tell no positions")));
  EXPECT_THAT(notesOf("padded"), ElementsAre(HasSubstr("of the value -3024 stand for padding")));
  EXPECT_THAT(notesOf("padded-range"),
              ElementsAre(HasSubstr("of the values -3124 to -3024 stand for padding")));
  EXPECT_THAT(notesOf("colors"), ElementsAre(HasSubstr("luminance")));
  EXPECT_THAT(notesOf("sizes"), ElementsAre(AllOf(HasSubstr("9 slices) of 2 is read"),
                                                  HasSubstr("(CT, 20 x 14, 1 slice)"))));
  EXPECT_THAT(notesOf("unsized"), ElementsAre(HasSubstr("do not tell the size of their pixels")));
}

TEST_F(DicomSeries, areChosenByTheirNumbers) {
  const auto source = open("several");
  EXPECT_THAT(source->layout().notes,
              ElementsAre(AllOf(HasSubstr("(CT, 20 x 14, 9 slices) of 3 is read"),
                                HasSubstr("(CT, 30 x 40, 1 slice)"),
                                HasSubstr("4 (MR, 20 x 14, 2 slices)"))));
  EXPECT_THAT(source->layout().grids, ElementsAre("3", "3-2", "4"));
  const auto other = open("several", {.grid = "4"});
  EXPECT_EQ(other->layout().dims, (Vec3i{20, 14, 2}));
  EXPECT_THAT(other->layout().notes, IsEmpty());
  EXPECT_NE(other->identity(), source->identity());
  EXPECT_EQ(other->files().size(), 2U);
  EXPECT_THAT(errorOf([&] { open("several", {.grid = "9"}); }),
              AllOf(HasSubstr("--grid 9"), HasSubstr("4 (MR, 20 x 14, 2 slices)")));
}

// A list of files and a pattern are the series that they are of.
TEST_F(DicomSeries, areReadFromListsOfFiles) {
  const auto source = openVolume((pathOf("ct") / "I*").string());
  EXPECT_TRUE(asText(readAll(*source)) == voxelsOf("ct"));
  EXPECT_EQ(openVolume((pathOf("ct") / "I000").string())->layout().dims.z, 1);
}

TEST_F(DicomSeries, failWhereTwoSlicesAreInOnePlace) {
  const TempFolder folder;
  fs::copy(pathOf("ct"), folder.path(), fs::copy_options::recursive);
  const std::string script = "import pydicom; d = pydicom.dcmread('" + (folder / "I000").string() +
                             "'); d.SOPInstanceUID = '1.2.77'; d.save_as('" +
                             (folder / "twin").string() + "')";
  ASSERT_EQ(runCommand("/usr/bin/python3 -c \"" + script + "\"").status, 0);
  EXPECT_THAT(errorOf([&] { openVolume(folder.path().string()); }),
              AllOf(HasSubstr("lies in the same place as"), HasSubstr("twin")));
}

TEST_F(DicomSeries, neverTellThePatientsName) {
  for (const DicomCase& c : cases_) {
    const auto source = open(c.name);
    const VolumeLayout& layout = source->layout();
    std::string said = layout.name + layout.unit + source->identity();
    for (const std::string& note : layout.notes) said += note;
    for (const std::string& grid : layout.grids) said += grid;
    for (char& letter : said) letter = static_cast<char>(std::tolower(letter));
    EXPECT_THAT(said, testing::Not(HasSubstr("xqz"))) << c.name;
  }
}

// Cut off and changed anywhere, they are Errors that name no patient, or volumes.
TEST_F(DicomSeries, surviveDamage) {
  for (const char* name : {"dose", "enhanced", "enhanced-delimited", "rle-enhanced"}) {
    if (!fs::exists(pathOf(name))) continue;
    const fs::path good = *fs::directory_iterator(pathOf(name));
    const TempFolder folder;
    surviveDamage(good, folder / "bad.dcm", 400, 0, [&](const fs::path& bad) {
      try {
        const auto source = openVolume(bad.string());
        if (volume(source->layout().dims) < 1 << 20) readAll(*source);
      } catch (const Error& error) {
        std::string text = error.what();
        for (char& letter : text) letter = static_cast<char>(std::tolower(letter));
        EXPECT_THAT(text, testing::Not(HasSubstr("xqz")));
        throw;
      }
    });
  }
}

TEST_F(DicomSeries, sayWhichModuleIsMissing) {
  if (hasDecoder() || !fs::exists(pathOf("jpeg-ct"))) GTEST_SKIP() << "the module is there";
  EXPECT_THAT(errorOf([&] { readAll(*open("jpeg-ct")); }),
              HasSubstr("a compressed DICOM image, which is not read without"));
}

// --- Samples

fs::path sample(const std::string& name) {
  return fs::path(SLUICE_DATA_DIR) / "formats/dicom" / name;
}

TEST(DicomSamples, haveTheNumbersThatPydicomReads) {
  if (!fs::exists(sample(""))) GTEST_SKIP() << sample("") << " is missing";
  if (!hasPythonModules("pydicom, gdcm"))
    GTEST_SKIP() << "python3 with pydicom and gdcm is missing";
  if (!hasDecoder()) GTEST_SKIP() << "the module for compressed DICOM images is missing";
  std::vector<std::string> names = {"CT_small.dcm",
                                    "JPEG2000.dcm",
                                    "MR_small.dcm",
                                    "MR_small_RLE.dcm",
                                    "MR_small_bigendian.dcm",
                                    "MR_small_expb.dcm",
                                    "MR_small_implicit.dcm",
                                    "MR_small_jp2klossless.dcm",
                                    "MR_small_jpeg_ls_lossless.dcm",
                                    "MR_small_padded.dcm",
                                    "rtdose.dcm",
                                    "rtdose_rle.dcm",
                                    "JPGExtended.dcm"};
  const TempFolder folder;
  std::string command = std::string("/usr/bin/python3 " SLUICE_TEST_DIR "/decode_dicom.py ") +
                        shellQuoted(folder.path().string());
  for (const std::string& name : names) command += " " + shellQuoted(sample(name).string());
  const auto made = runCommand(command);
  ASSERT_EQ(made.status, 0) << made.output;
  for (const std::string& name : names) {
    const auto source = openVolume(sample(name).string());
    EXPECT_TRUE(asText(readAll(*source)) == readFile(folder / (name + ".bin"))) << name;
  }
}

TEST(DicomSamples, thatAreNoImagesAreRefusedInOneLine) {
  if (!fs::exists(sample(""))) GTEST_SKIP() << sample("") << " is missing";
  const auto refusal = [](const std::string& name) {
    return errorOf([&] { readAll(*openVolume(sample(name).string())); });
  };
  EXPECT_THAT(refusal("dicomdirtests/DICOMDIR"), HasSubstr("a DICOMDIR"));
  EXPECT_THAT(refusal("dicomdirtests/DICOMDIR-bigEnd"), HasSubstr("a DICOMDIR"));
  EXPECT_THAT(refusal("dicomdirtests/DICOMDIR-implicit"), HasSubstr("a DICOMDIR"));
  EXPECT_THAT(refusal("dicomdirtests/TINY_ALPHA"), HasSubstr("none of its 51 DICOM files"));
  EXPECT_THAT(refusal("MR_truncated.dcm"), HasSubstr("cut short"));
  EXPECT_THAT(refusal("badVR.dcm"), HasSubstr("(0028,0008)"));
  EXPECT_THAT(refusal("liver_1frame.dcm"), HasSubstr("1 bits in 1"));
  EXPECT_THAT(refusal("no_meta.dcm"), HasSubstr("expected a DICOM file"));
}

TEST(DicomSamples, ofManySeriesAreListed) {
  if (!fs::exists(sample(""))) GTEST_SKIP() << sample("") << " is missing";
  const auto source = openVolume(sample("dicomdirtests").string());
  EXPECT_EQ(source->layout().dims, (Vec3i{16, 16, 5}));
  EXPECT_THAT(source->layout().notes,
              ElementsAre(AllOf(HasSubstr("series 5 (CT, 16 x 16, 5 slices)"),
                                HasSubstr("2 (CT, 16 x 16, 4")),
                          HasSubstr("PixelPaddingValue")));
  const auto gapped = openVolume(sample("dicomdirtests/77654033/CT2").string());
  EXPECT_THAT(gapped->layout().notes, ElementsAre(HasSubstr("161 slices are missing, 1.25"),
                                                  HasSubstr("PixelPaddingValue")));
}

}  // namespace
}  // namespace sluice
