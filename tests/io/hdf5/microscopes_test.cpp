#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "io/hdf5/bdv_xml.h"
#include "io/open_volume.h"
#include "io/zarr/packing/zarr_writer.h"
#include "src/base/sources/volume_channels.h"
#include "src/base/sources/volume_levels.h"
#include "tests/io/python_volumes.h"
#include "tests/io/zarr/zarr_case.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

struct MicroscopeCase : ZarrCase {
  static constexpr const char* kScript = "make_microscopes.py";
  static constexpr const char* kModules = "numpy, h5py, zarr, numcodecs";
};

class Microscopes : public PythonVolumesTest<MicroscopeCase> {
 protected:
  static std::unique_ptr<VolumeSource> open(const std::string& name, int64_t channel = 1) {
    return openVolume(pathOf(name).string(), {.channel = channel});
  }
  // The error from a changed copy of an .xml.
  static std::string errorOfChanged(const std::string& from, const std::string& to) {
    std::string text = readFile(pathOf("hdf5.xml"));
    EXPECT_NE(text.find(from), std::string::npos) << from;
    for (size_t at = text.find(from); at != text.npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
    const fs::path file = pathOf("changed.xml");
    std::ofstream(file, std::ios::binary) << text;
    return errorOf([&] { allSteps(*openVolume(file.string())); });
  }
};

TEST_F(Microscopes, imagesAreReadAsTheyWereWritten) {
  ASSERT_EQ(cases_.size(), 4U);
  for (const MicroscopeCase& c : cases_) {
    SCOPED_TRACE(c.name);
    const auto source = open(c.name, c.channel);
    EXPECT_EQ(source->layout().dims, c.dims);
    EXPECT_EQ(name(source->layout().type), c.type);
    EXPECT_EQ(source->layout().time_steps, c.steps);
    EXPECT_EQ(source->layout().channels, 2);
    const std::string whole = voxelsOf(c.name);
    EXPECT_TRUE(allSteps(*source) == whole);
    expectBoxesAreParts(*source, whole);
    const std::span<const CoarserLevel> levels = coarserLevels(*source);
    ASSERT_EQ(levels.size(), 1U);
    EXPECT_EQ(levels[0].placement, (LevelPlacement{{2, 2, 2}, {0.5, 0.5, 0.5}}));
    EXPECT_TRUE(asText(readAll(*levels[0].source, 1)) == voxelsOf(c.name + ".level"));
  }
}

TEST_F(Microscopes, placesUnitsAndNamesAreRead) {
  const auto imaris = open("image.ims");
  EXPECT_EQ(imaris->layout().spacing, (Vec3d{0.5, 0.5, 2}));
  EXPECT_EQ(imaris->layout().origin, (Vec3d{1.25, 0.25, -4}));
  EXPECT_EQ(imaris->layout().unit, "micrometer");
  EXPECT_THAT(channelNames(*imaris), ElementsAre("DAPI", "GFP"));
  for (const std::string name : {"hdf5.xml", "n5.xml"}) {
    const auto source = open(name);
    EXPECT_EQ(source->layout().spacing, (Vec3d{0.5, 0.5, 2})) << name;
    EXPECT_EQ(source->layout().origin, (Vec3d{1, 2, 3})) << name;
    EXPECT_EQ(source->layout().unit, "micrometer");
    EXPECT_THAT(channelNames(*source), ElementsAre("DAPI", "GFP"));
  }
  EXPECT_THAT(open("moved.xml")->layout().notes,
              ElementsAre(HasSubstr("set-up 1 lies elsewhere at other time points")));
  const VolumeLayout turned = open("turned.xml")->layout();
  EXPECT_THAT(turned.axes, ElementsAre(Vec3d{0, 1, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 0, 1}));
  EXPECT_EQ(coarserLevels(*open("turned.xml"))[0].placement.offset, (Vec3d{0.5, 0.5, 0.5}));
}

// The N5 store has voxels of them.
TEST_F(Microscopes, missingViewsAreEmptyAndNamed) {
  for (const std::string name : {"missing.xml", "missing_n5.xml"}) {
    SCOPED_TRACE(name);
    const auto source = open(name), whole = open("bdv.h5");
    EXPECT_THAT(source->layout().notes,
                ElementsAre(HasSubstr("set-up 1 has no view at the time points 0, 2 (MissingViews) "
                                      "and is empty there")));
    EXPECT_EQ(source->layout().time_steps, 3);
    const std::vector<std::byte> empty(readAll(*whole, 0).size());
    EXPECT_TRUE(readAll(*source, 0) == empty);
    EXPECT_TRUE(readAll(*source, 1) == readAll(*whole, 1));
    EXPECT_TRUE(readAll(*source, 2) == empty);
    EXPECT_TRUE(readAll(*coarserLevels(*source)[0].source, 1) ==
                readAll(*coarserLevels(*whole)[0].source, 1));
    EXPECT_THAT(errorOf([&] { open(name, 0); }),
                HasSubstr("set-up 0 has no view at any time point (MissingViews)"));
  }
}

// Packed as one array, they lost voxels or got those beyond their own.
TEST_F(Microscopes, channelsMayDifferInSizeAndAreNotPackedTogether) {
  const auto first = open("cut.ims", 0), second = open("cut.ims", 1);
  EXPECT_EQ(first->layout().dims, (Vec3i{14, 12, 10}));
  EXPECT_EQ(second->layout().dims, (Vec3i{13, 12, 10}));
  EXPECT_EQ(second->layout().spacing, first->layout().spacing);
  const std::vector<VolumeSource*> channels{first.get(), second.get()};
  EXPECT_THAT(errorOf([&] { packedBytes(channels); }),
              HasSubstr("cut.ims: channel 1 has 13 x 12 x 10 voxels in 3 time steps, the first 14 "
                        "x 12 x 10 in 3: a store has channels that are alike; pack each with "
                        "--channel"));
}

TEST_F(Microscopes, wrongFilesAreOneLine) {
  const std::pair<std::pair<std::string, std::string>, std::string> wrong[] = {
      {{"bdv.hdf5", "bdv.imaris"}, "expected an ImageLoader of bdv.hdf5 or bdv.n5"},
      {{"bdv.h5<", "none.h5<"}, "none.h5"},
      {{"<last>2", "<last>x"}, "the last time point, found 'x'"},
      {{"<last>2", "<last>9999999999"}, "time points"},
      {{"<last>2", "<last>9"}, "/t00003/s00/0/cells"},
      {{"<id>0", "<id>-1"}, "the id of a set-up"},
      {{"<id>0", "<id>7"}, "/s07/resolutions"},
      {{"0.5 0 0 0 0 0.5 0 0 0 0 2 0", "0.5 0 0"}, "12 numbers of an affine"},
      {{"0.5 0 0 0 0 0.5 0 0 0 0 2 0", "0 0 0 0 0 0.5 0 0 0 0 2 0"}, "steps between voxels"},
      {{"<SequenceDescription>", "<SequenceDescription"}, "expected XML"}};
  for (const auto& [change, said] : wrong)
    EXPECT_THAT(errorOfChanged(change.first, change.second), HasSubstr(said));
}

BdvImage imageOfPattern(const std::string& pattern) {
  const std::string text =
      "<SpimData><SequenceDescription><ImageLoader format='bdv.n5'><n5>a.n5</n5></ImageLoader>"
      "<ViewSetups><ViewSetup><id>4</id></ViewSetup></ViewSetups><Timepoints type='pattern'>"
      "<integerpattern>" +
      pattern + "</integerpattern></Timepoints></SequenceDescription></SpimData>";
  return parseBdvXml(
      [&](uint64_t offset, std::span<std::byte> out) {
        const std::string part = text.substr(std::min<size_t>(offset, text.size()), out.size());
        std::memcpy(out.data(), part.data(), part.size());
        return part.size();
      },
      "v.xml");
}

TEST(BdvXml, timePointsMayBeAPattern) {
  const BdvImage image = imageOfPattern("7, 1-3, 10-20:5");
  EXPECT_THAT(image.times, ElementsAre(1, 2, 3, 7, 10, 15, 20));
  EXPECT_EQ(image.setups[0].id, 4);
  // The time after it does not fit into its type.
  EXPECT_THAT(imageOfPattern("9223372036854775807").times, ElementsAre(INT64_MAX));
}

}  // namespace
}  // namespace sluice
