#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "io/hdf5/hdf5_filters.h"
#include "io/open_volume.h"
#include "src/base/sources/read_units.h"
#include "tests/io/python_volumes.h"
#include "tests/io/zarr/zarr_case.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

struct Hdf5Case : ZarrCase {
  static constexpr const char* kScript = "make_hdf5.py";
  static constexpr const char* kModules = "numpy, h5py";
  // The name of the file of its voxels.
  std::string bin() const {
    std::string all = name;
    return all.replace(all.find(":/"), 2, ".");
  }
};

class Hdf5 : public PythonVolumesTest<Hdf5Case> {
 protected:
  static std::unique_ptr<VolumeSource> open(const std::string& name, OpenOptions options = {}) {
    options.chunk_cache_bytes = 1;
    return openVolume(pathOf(name).string(), options);
  }
};

TEST_F(Hdf5, dataSetsAreReadAsTheyWereWritten) {
  ASSERT_GT(cases_.size(), 70U);
  for (const Hdf5Case& c : cases_) {
    SCOPED_TRACE(c.name);
    OpenOptions options;
    if (c.channel >= 0) options.channel = c.channel;
    const auto source = open(c.name, options);
    EXPECT_EQ(source->layout().dims, c.dims);
    EXPECT_EQ(name(source->layout().type), c.type);
    EXPECT_EQ(source->layout().time_steps, c.steps);
    const std::string whole = voxelsOf(c.bin());
    EXPECT_TRUE(allSteps(*source) == whole);
    expectBoxesAreParts(*source, whole);
  }
}

TEST_F(Hdf5, aFileOfOneVolumeNeedsNoPath) {
  EXPECT_TRUE(asText(readAll(*open("one.h5"))) == voxelsOf("one.h5.only"));
  EXPECT_THAT(errorOf([] { open("none.h5"); }),
              HasSubstr("expected a data set of three axes or more, found none"));
  EXPECT_THAT(errorOf([] { open("flat.h5"); }),
              AllOf(HasSubstr("found /first (13 x 17), /second (13 x 17); name one"),
                    HasSubstr("flat.h5:/first")));
  EXPECT_EQ(open("flat.h5:/first")->layout().dims, (Vec3i{17, 13, 1}));
  EXPECT_THAT(errorOf([] { open("sets.h5"); }),
              AllOf(HasSubstr("sets.h5:/a/b/deep"), HasSubstr("11 x 13 x 17"), HasSubstr("...")));
}

TEST_F(Hdf5, setsInSeveralFilesAreTimeSteps) {
  const TempFolder folder;
  for (const int step : {0, 1, 3})
    fs::copy_file(pathOf("sets.h5"), folder / fmt::format("s_{:03}.h5", step));
  for (const char* pattern : {"s_###.h5:/sized", "s_%03d.h5:/sized", "s_*.h5:/sized"}) {
    const auto source = openVolume((folder / pattern).string());
    EXPECT_EQ(source->layout().time_steps, 3);
    EXPECT_EQ(source->layout().spacing, (Vec3d{0.25, 0.5, 2}));
    EXPECT_THAT(source->layout().notes, testing::Contains(HasSubstr("s_002.h5:/sized is missing")));
    EXPECT_EQ(readAll(*source, 2), readAll(*open("sets.h5:/sized")));
  }
  const auto steps = [&](const std::string& second) {
    return openVolume(std::vector<std::string>{(folder / "s_000.h5:/sized").string(),
                                               (folder / ("s_001.h5:/" + second)).string()});
  };
  // One file may have several sets of one size.
  EXPECT_NE(steps("flat_uint8_little")->identity(), steps("flat_uint8_big")->identity());
}

TEST_F(Hdf5, placesAndScalesAreRead) {
  const VolumeLayout sized = open("sets.h5:/sized")->layout();
  EXPECT_EQ(sized.spacing, (Vec3d{0.25, 0.5, 2}));
  EXPECT_EQ(sized.unit, "micrometer");
  EXPECT_EQ(open("sets.h5:/tagged_chunked")->layout().spacing, (Vec3d{0.25, 0.5, 2}));
  EXPECT_EQ(open("sets.h5:/tagged")->layout().channels, 3);
  const VolumeLayout packed = open("packed.nc")->layout();
  EXPECT_EQ(packed.value_scale, 0.5);
  EXPECT_EQ(packed.value_offset, 10);
}

TEST_F(Hdf5, dimensionScalesGiveThePlace) {
  const VolumeLayout grid = open("grid.nc")->layout();
  EXPECT_EQ(grid.spacing, (Vec3d{0.25, 0.5, 2}));
  EXPECT_EQ(grid.origin, (Vec3d{-1, 0, 10}));
  EXPECT_EQ(grid.axes[2], (Vec3d{0, 0, -1}));  // its numbers decrease
  EXPECT_EQ(grid.unit, "millimeter");
  EXPECT_THAT(grid.notes, testing::IsEmpty());
  const VolumeLayout units = open("units.nc")->layout();
  EXPECT_EQ(units.spacing, (Vec3d{0.25, 500, 2000}));
  EXPECT_EQ(units.unit, "micrometer");
  const VolumeLayout turned = open("turned.nc")->layout();
  EXPECT_EQ(turned.dims, (Vec3i{3, 4, 5}));
  EXPECT_EQ(turned.spacing, (Vec3d{0.25, 0.5, 2}));
  const VolumeLayout hours = open("hours.nc")->layout();
  EXPECT_EQ(hours.spacing, (Vec3d{0.25, 0.5, 2}));
  EXPECT_EQ(hours.time_steps, 1);
}

TEST_F(Hdf5, positionsThatASpacingCannotTellAreWarnedOf) {
  const VolumeLayout uneven = open("uneven.nc")->layout();
  EXPECT_EQ(uneven.spacing, (Vec3d{0.25, 0.5, 2}));
  EXPECT_THAT(uneven.notes, ElementsAre(HasSubstr(
                                "uneven.nc:/v: the coordinates of its axis /z are 1 to 3 apart; "
                                "its voxels are drawn evenly, 2 apart")));
  const VolumeLayout pressure = open("pressure.nc")->layout();
  EXPECT_EQ(pressure.spacing, (Vec3d{1, 1, 1}));
  EXPECT_THAT(pressure.notes, ElementsAre(HasSubstr("different units (hPa, degree, degree)")));
  const VolumeLayout degrees = open("degrees.nc")->layout();
  EXPECT_EQ(degrees.spacing, (Vec3d{0.25, 0.5, 1}));
  EXPECT_EQ(degrees.unit, "degree");
  EXPECT_THAT(degrees.notes, ElementsAre(HasSubstr("its axis lev has no coordinates")));
  const VolumeLayout layer = open("layer.nc")->layout();
  EXPECT_EQ(layer.spacing, (Vec3d{0.25, 0.5, 1}));
  EXPECT_THAT(layer.notes, testing::IsEmpty());
}

// Floats of these numbers are NaN (dataSetsAreReadAsTheyWereWritten).
TEST_F(Hdf5, integersThatStandForMissingValuesAreWarnedOf) {
  EXPECT_THAT(open("masked.nc")->layout().notes, testing::IsEmpty());
  EXPECT_THAT(open("gaps.nc")->layout().notes,
              ElementsAre(HasSubstr("voxels of the value -16383 stand for missing values")));
  EXPECT_THAT(open("unsigned.nc")->layout().notes, ElementsAre(HasSubstr("the value 255")));
}

// A voxel of a set in one piece costs its own bytes, one of a chunk the chunk.
TEST_F(Hdf5, valuesThatTheFileCallsInvalidAreWarnedOf) {
  EXPECT_THAT(open("valid.nc")->layout().notes,
              ElementsAre(HasSubstr("values below -5 or above 150 are invalid by the file")));
  EXPECT_THAT(open("positive.nc")->layout().notes,
              ElementsAre(HasSubstr("values below 0 are invalid by the file")));
  EXPECT_THAT(open("all-valid.nc")->layout().notes, testing::IsEmpty());
}

TEST_F(Hdf5, onlyWhatIsNeededIsRead) {
  const auto flat = open("sets.h5:/flat_float64_little");
  const uint64_t before = flat->storedBytesRead();
  readBox(*flat, {{3, 2, 1}, {4, 3, 2}}, 0);
  EXPECT_EQ(flat->storedBytesRead() - before, 8U);
  const auto chunked = open("sets.h5:/packed_plain_4");
  EXPECT_EQ(readUnits(*chunked).voxels, (Vec3i{6, 5, 4}));
  const uint64_t unread = chunked->storedBytesRead();
  readBox(*chunked, {{0, 0, 0}, {6, 5, 4}}, 0);
  EXPECT_LE(chunked->storedBytesRead() - unread, 6U * 5 * 4 * 2 + 8);
}

// The library keeps in each thread whether it prints its own reports.
TEST_F(Hdf5, chunksThatAreNotThereAreReadInSilenceByAnyThread) {
  const auto source = open("sets.h5:/holes_uint8");
  testing::internal::CaptureStderr();
  std::thread([&] { readAll(*source); }).join();
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(Hdf5, wrongNamesAndSetsAreOneLine) {
  const std::pair<std::string, std::string> wrong[] = {
      {"sets.h5:/nothing", "expected a data set /nothing, found none"},
      {"sets.h5:/a", "cannot be opened"},
      {"sets.h5:/long", "floats of 32 or 64, found integers of 64 bits"},
      {"sets.h5:/virtual", "a virtual data set"},
      {"sets.h5:/elsewhere", "leads to another file"}};
  for (const auto& [file, said] : wrong)
    EXPECT_THAT(errorOf([&, file = file] { open(file); }),
                AllOf(HasSubstr("sets.h5:"), HasSubstr(said)));
  for (const auto& [type, said] : {std::pair<std::string, std::string>{"half", "floats of 16 bits"},
                                   {"text", "texts"},
                                   {"record", "records of 2 members (8 bytes)"}})
    EXPECT_THAT(errorOf([&, type = type] { open("types.h5:/" + type); }),
                HasSubstr("found " + said));
  // One axis: a volume of one row.
  EXPECT_EQ(open("one.h5:/x")->layout().dims, (Vec3i{17, 1, 1}));
}

TEST_F(Hdf5, aFileThatIsCutIsNamedAtAnyLength) {
  const TempFolder folder;
  const std::string whole = readFile(pathOf("one.h5"));
  for (const size_t bytes : {whole.size() - 1, whole.size() / 2, size_t{1100}, size_t{1030}}) {
    std::ofstream(folder / "v.h5", std::ios::binary) << whole.substr(0, bytes);
    EXPECT_THAT(errorOf([&] { readAll(*openVolume((folder / "v.h5").string())); }),
                HasSubstr("v.h5"))
        << bytes;
  }
}

TEST(Hdf5Filters, damagedChunksAreNamed) {
  const std::vector<Hdf5Filter> sum{{.number = 3, .name = "fletcher32", .values = {}}};
  std::vector<std::byte> stored(8), chunk(4);
  stored[0] = std::byte{1};
  EXPECT_THAT(errorOf([&] { undoFilters(sum, 0, stored, chunk, "v"); }),
              HasSubstr("v: expected the checksum"));
  for (const int number : {1, 2, 32000, 32001, 32004, 32015}) {
    const std::vector<Hdf5Filter> one{{.number = number, .name = "", .values = {4}}};
    std::vector<std::byte> noise(9, std::byte{0x55});
    EXPECT_THAT(errorOf([&] { undoFilters(one, 0, noise, chunk, "v"); }), HasSubstr("v: expected"))
        << number;
  }
  // A filter that was left out.
  std::vector<std::byte> plain(4, std::byte{5});
  undoFilters(sum, 1, plain, chunk, "v");
  EXPECT_EQ(chunk[3], std::byte{5});
}

}  // namespace
}  // namespace sluice
