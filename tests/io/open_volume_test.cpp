#include "io/open_volume.h"

#include <gmock/gmock.h>

#include <cstring>

#include "io/formats.h"
#include "io/pictures/png_file.h"
#include "tests/io/image_test_support.h"
#include "tests/support/vdb_writer.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A grey PNG of 4 x 3 pixels, all of one value.
void writeSlice(const std::filesystem::path& path, uint8_t value) {
  Rgba8Picture picture{4, 3, std::vector<uint8_t>(48, value)};
  writePng(path, picture);
}

TEST(OpenVolume, knowsAFileByItsFirstBytesWhateverItsName) {
  const TempFolder folder;
  writePoints(folder / "a.raw", {{{0, 0, 0}, 2.0F}});
  writeSlice(folder / "b.vdb", 9);
  writeFile(folder / "c.txt",
            "NRRD0001\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n12345678");
  writeFile(
      folder / "d",
      "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n12345678");
  EXPECT_EQ(openVolume((folder / "a.raw").string())->layout().dims, (Vec3i{3, 3, 3}));
  EXPECT_EQ(openVolume((folder / "b.vdb").string())->layout().dims, (Vec3i{4, 3, 1}));
  EXPECT_EQ(valueAt<uint8_t>(*openVolume((folder / "c.txt").string()), {1, 0, 0}), '2');
  EXPECT_EQ(valueAt<uint8_t>(*openVolume((folder / "d").string()), {1, 0, 0}), '2');
}

TEST(OpenVolume, refusesMoreVoxelsThanCanBeCounted) {
  const TempFolder folder;
  constexpr int32_t kFar = (1 << 22) - 1;
  writePoints(folder / "sparse.vdb", {{{0, 0, 0}, 1.0F}, {{kFar, kFar, kFar}, 2.0F}});
  EXPECT_THAT(errorOf([&] { openVolume((folder / "sparse.vdb").string()); }),
              AllOf(HasSubstr("sparse.vdb"), HasSubstr("2^59"),
                    HasSubstr("found 4194306 x 4194306 x 4194306")));
}

TEST(OpenVolume, namesTheSchemesOfAddresses) {
  for (const std::string name : {"gs://bucket/a.zarr", "HTTP://host/a.zarr", "file:///a.nrrd"})
    EXPECT_THAT(errorOf([&] { openVolume(name); }),
                AllOf(HasSubstr(name), HasSubstr("http://, https:// or s3://")));
}

// A folder, an empty file and files of other kinds by the name of each format.
TEST(OpenVolume, refusesWhatItsNameDoesNotHold) {
  const TempFolder folder;
  const std::string junk(5000, '\x7f');
  for (const std::string_view ending : volumeEndings()) {
    const auto refuses = [&](std::string_view kind, const std::string* bytes) {
      const auto path = folder / fmt::format("{}{}", kind, ending);
      if (bytes == nullptr)
        std::filesystem::create_directory(path);
      else
        writeFile(path, *bytes);
      const std::string refusal = errorOf([&] { openVolume(path.string()); });
      EXPECT_THAT(refusal, HasSubstr(path.filename().string() + ": "));
      EXPECT_EQ(std::ranges::count(refusal, '\n'), 0);
    };
    const std::string none, zip = "PK\3\4" + junk;
    refuses("folder", nullptr);
    refuses("empty", &none);
    refuses("junk", &junk);
    refuses("zip", &zip);
  }
}

TEST(OpenVolume, takesRawFilesFromTheirNamesOrTheOptions) {
  const TempFolder folder;
  writeFile(folder / "a_2x2x2_uint8.raw", "12345678");
  writeFile(folder / "b", "xx12345678");
  EXPECT_EQ(valueAt<uint8_t>(*openVolume((folder / "a_2x2x2_uint8.raw").string()), {1, 1, 1}), '8');
  const auto source = openVolume((folder / "b").string(), {.dims = Vec3i{2, 1, 2},
                                                           .type = VoxelType::kU16,
                                                           .byte_order = std::endian::big,
                                                           .skip_bytes = 2,
                                                           .spacing = Vec3d{1, 2, 3}});
  EXPECT_EQ(valueAt<uint16_t>(*source, {0, 0, 0}), ('1' << 8) + '2');
  EXPECT_EQ(source->layout().spacing, (Vec3d{1, 2, 3}));
}

// The first voxels of these files are the tag of an element of DICOM, with a small length behind
// it.
TEST(OpenVolume, takesNoRawFileForDicom) {
  const TempFolder folder;
  const std::string zeros(1024, '\0');
  for (const std::vector<uint16_t>& voxels : std::vector<std::vector<uint16_t>>{
           {8, 5}, {8, 22}, {8, 8, 2}, {2, 0}, {2, 1, 4, 0, 1, 1, 2, 2}}) {
    std::string bytes = zeros;
    std::memcpy(bytes.data(), voxels.data(), voxels.size() * sizeof(uint16_t));
    writeFile(folder / "labels_8x8x8.raw", bytes);
    writeFile(folder / "a_8x8x8_uint16.raw", bytes);
    writeFile(folder / "b", bytes);
    for (const char* name : {"labels_8x8x8.raw", "a_8x8x8_uint16.raw", "b"}) {
      const auto source =
          openVolume((folder / name).string(), {.dims = Vec3i{8, 8, 8}, .type = VoxelType::kU16});
      EXPECT_EQ(valueAt<uint16_t>(*source, {0, 0, 0}), voxels[0]);
      EXPECT_EQ(valueAt<uint16_t>(*source, {1, 0, 0}), voxels[1]);
    }
    EXPECT_NO_THROW(openVolume((folder / "a_8x8x8_uint16.raw").string()));
    EXPECT_THAT(errorOf([&] { openVolume((folder / "b").string()); }), HasSubstr("unknown kind"));
  }
  // Size and type count more than a look at the bytes, and less than a mark that only DICOM has.
  std::string bytes("\x08\0\x05\0CS\x0a\0ISO_IR 100\x08\0\x08\0CS\x02\0AB", 28);
  bytes += zeros.substr(bytes.size());
  writeFile(folder / "c", bytes);
  EXPECT_THAT(errorOf([&] { openVolume((folder / "c").string()); }), HasSubstr("DICOM"));
  EXPECT_NO_THROW(
      openVolume((folder / "c").string(), {.dims = Vec3i{8, 8, 8}, .type = VoxelType::kU16}));
  bytes.replace(128, 4, "DICM");
  writeFile(folder / "d", bytes);
  EXPECT_THAT(
      errorOf([&] {
        openVolume((folder / "d").string(), {.dims = Vec3i{8, 8, 8}, .type = VoxelType::kU16});
      }),
      HasSubstr("the file contains its size"));
}

TEST(OpenVolume, takesAFolderOrAPatternOfSlices) {
  const TempFolder folder;
  for (const int n : {0, 1, 2, 9, 10, 11})
    writeSlice(folder / fmt::format("s-{}.png", n), static_cast<uint8_t>(n));
  writeFile(folder / "notes.txt", "of no interest");
  for (const std::string& input :
       {folder.path().string(), (folder / "s-%d.png").string(), (folder / "s-*.png").string()}) {
    const auto source = openVolume(input, {.spacing = Vec3d{1, 1, 2}});
    EXPECT_EQ(source->layout().dims, (Vec3i{4, 3, 6}));
    EXPECT_EQ(source->layout().time_steps, 1);
    EXPECT_EQ(source->layout().spacing, (Vec3d{1, 1, 2}));
    EXPECT_EQ(valueAt<uint8_t>(*source, {3, 2, 3}), 9);
    EXPECT_EQ(valueAt<uint8_t>(*source, {0, 0, 4}), 10);
  }
  // A shell's order becomes the order of the numbers. Any other order is the user's.
  const auto at = [&](int n) { return (folder / fmt::format("s-{}.png", n)).string(); };
  const auto sorted = openVolume({at(10), at(2), at(9)});
  EXPECT_EQ(valueAt<uint8_t>(*sorted, {0, 0, 0}), 2);
  EXPECT_EQ(valueAt<uint8_t>(*sorted, {0, 0, 2}), 10);
  EXPECT_THAT(sorted->layout().notes, testing::Contains(HasSubstr("order of their numbers")));
  const auto backwards = openVolume({at(10), at(9), at(2)});
  EXPECT_EQ(valueAt<uint8_t>(*backwards, {0, 0, 0}), 10);
  EXPECT_THAT(backwards->layout().notes, testing::Contains(HasSubstr("in the order given")));
  EXPECT_THAT(openVolume({at(9), at(10)})->layout().notes,
              testing::Not(testing::Contains(HasSubstr("order"))));
}

TEST(OpenVolume, takesAPatternOfVolumesAsTimeSteps) {
  const TempFolder folder;
  writeFile(folder / "step_000.raw", "12345678");
  writeFile(folder / "step_010.raw", "abcdefgh");
  writeFile(folder / "step_100.raw", "ABCDEFGH");
  const OpenOptions options{.dims = Vec3i{2, 2, 2}, .type = VoxelType::kU8};
  const auto source = openVolume((folder / "step_%03d.raw").string(), options);
  EXPECT_EQ(source->layout().time_steps, 3);
  EXPECT_EQ(valuesOf<char>(readBox(*source, {{0, 0, 0}, {2, 1, 1}}, 1)),
            (std::vector<char>{'a', 'b'}));
  EXPECT_EQ(valuesOf<char>(readBox(*source, {{0, 0, 0}, {2, 1, 1}}, 2)),
            (std::vector<char>{'A', 'B'}));
  writeFile(folder / "step_010.raw", "abcdefghi");
  const auto damaged = openVolume((folder / "step_%03d.raw").string(), options);
  EXPECT_THAT(errorOf([&] { readAll(*damaged, 1); }), HasSubstr("step_010.raw"));
}

TEST(OpenVolume, takesAPatternOfStoresAsTimeSteps) {
  const TempFolder folder;
  for (const char step : {'0', '1', '3'}) {
    const auto store = folder / fmt::format("t_{}.zarr/a", step);
    std::filesystem::create_directories(store);
    writeFile(store / ".zarray",
              R"({"zarr_format": 2, "shape": [2, 2, 2], "chunks": [2, 2, 2], "dtype": "|u1",
                  "compressor": null, "fill_value": 0, "order": "C", "filters": null})");
    writeFile(store / "0.0.0", std::string(8, step));
  }
  for (const char* pattern : {"t_#.zarr/a", "t_%d.zarr/a", "t_*.zarr/a"}) {
    const auto source = openVolume((folder / pattern).string());
    EXPECT_EQ(source->layout().time_steps, 3);
    EXPECT_EQ(valuesOf<char>(readBox(*source, {{0, 0, 0}, {1, 1, 1}}, 2)), std::vector<char>{'3'});
    EXPECT_THAT(source->layout().notes, testing::Contains(HasSubstr("t_2.zarr/a is missing")));
  }
}

TEST(OpenVolume, takesFoldersOfSlicesAsTimeSteps) {
  const TempFolder folder;
  for (const int t : {0, 1}) {
    std::filesystem::create_directory(folder / std::to_string(t));
    for (const int n : {0, 1, 2})
      writeSlice(folder / fmt::format("{}/{}.png", t, n), static_cast<uint8_t>(10 * t + n));
  }
  const auto source = openVolume({(folder / "0").string(), (folder / "1").string()});
  EXPECT_EQ(source->layout().time_steps, 2);
  EXPECT_EQ(source->layout().dims, (Vec3i{4, 3, 3}));
  std::vector<std::byte> out(1);
  source->readRegion(1, {{0, 0, 2}, {1, 1, 3}}, out);
  EXPECT_EQ(out[0], std::byte{12});
}

TEST(OpenVolume, saysWhatTheAxesOfTheWorldMean) {
  const TempFolder folder;
  writeSlice(folder / "a.png", 1);
  writePoints(folder / "a.vdb", {{{0, 0, 0}, 2.0F}});
  EXPECT_EQ(openVolume((folder / "a.png").string())->layout().frame, WorldFrame::kPictureRows);
  EXPECT_EQ(openVolume((folder / "a.vdb").string())->layout().frame, WorldFrame::kYUp);
  EXPECT_EQ(openVolume("synth:cube,dims=5x6x7")->layout().frame, WorldFrame::kNone);
}

TEST(OpenVolume, listsEveryFileThatAVolumeIsReadFrom) {
  const TempFolder folder;
  const auto at = [&](const std::string& name) { return (folder / name).string(); };
  const auto filesOf = [](const std::vector<std::string>& inputs, const OpenOptions& options = {}) {
    return openVolume(inputs, options)->files();
  };
  const OpenOptions raw{.dims = Vec3i{2, 2, 2}, .type = VoxelType::kU8};
  for (const char* name : {"a.raw", "b.raw", "c.raw"}) writeFile(folder / name, "12345678");
  EXPECT_THAT(filesOf({at("a.raw")}, raw), testing::ElementsAre(at("a.raw")));
  const std::string nrrd = "NRRD0001\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n";
  writeFile(folder / "b.nhdr", nrrd + "data file: b.raw\n");
  writeFile(folder / "c.nhdr", nrrd + "data file: c.raw\n");
  EXPECT_THAT(filesOf({at("b.nhdr")}), testing::UnorderedElementsAre(at("b.nhdr"), at("b.raw")));
  EXPECT_THAT(filesOf({at("b.nhdr"), at("c.nhdr")}, {.spacing = Vec3d{1, 1, 2}}),
              testing::UnorderedElementsAre(at("b.nhdr"), at("b.raw"), at("c.nhdr"), at("c.raw")));
  for (const char* name : {"s0.png", "s1.png"}) writeSlice(folder / name, 1);
  EXPECT_THAT(filesOf({at("s%d.png")}), testing::ElementsAre(at("s0.png"), at("s1.png")));
  writePoints(folder / "p.vdb", {{{0, 0, 0}, 2.0F}});
  EXPECT_THAT(filesOf({at("p.vdb")}), testing::ElementsAre(at("p.vdb")));
  std::filesystem::create_directory(folder / "z");
  writeFile(folder / "z/.zarray",
            R"({"zarr_format": 2, "shape": [2, 2, 2], "chunks": [2, 2, 2], "dtype": "|u1",
                "compressor": null, "fill_value": 0, "order": "C", "filters": null})");
  EXPECT_THAT(filesOf({at("z")}), testing::Contains(at("z")));
  EXPECT_THAT(filesOf({"synth:cube,dims=5x6x7"}), testing::IsEmpty());
}

TEST(OpenVolume, makesSyntheticVolumes) {
  EXPECT_EQ(openVolume("synth:cube,dims=5x6x7")->layout().dims, (Vec3i{5, 6, 7}));
}

TEST(OpenVolume, spacingReplacesWhatTheFileSays) {
  const TempFolder folder;
  writePoints(folder / "a.vdb", {{{0, 0, 0}, 2.0F}});
  const auto source = openVolume((folder / "a.vdb").string(), {.spacing = Vec3d{1, 2, 3}});
  EXPECT_EQ(source->layout().spacing, (Vec3d{1, 2, 3}));
  EXPECT_EQ(valueAt<float>(*source, {1, 1, 1}), 2.0F);
  EXPECT_TRUE(source->occupancy(0).has_value());
  EXPECT_THAT(errorOf([&] {
                openVolume((folder / "a.vdb").string(), {.spacing = Vec3d{1, 0, 3}});
              }),
              HasSubstr("three positive numbers"));
}

TEST(OpenVolume, refusesOptionsThatWouldHaveNoEffect) {
  const TempFolder folder;
  writePoints(folder / "a.vdb", {{{0, 0, 0}, 2.0F}});
  writeSlice(folder / "b.png", 1);
  EXPECT_THAT(errorOf([&] {
                openVolume((folder / "a.vdb").string(), {.dims = Vec3i{1, 1, 1}});
              }),
              HasSubstr("are for raw files"));
  EXPECT_THAT(errorOf([&] { openVolume((folder / "b.png").string(), {.grid = "density"}); }),
              HasSubstr("--grid density is for OpenVDB"));
}

TEST(OpenVolume, saysWhatIsWrongWithAName) {
  const TempFolder folder;
  writeFile(folder / "a.txt", "hello");
  writeFile(folder / "empty", "");
  writeFile(folder / "a.nrrd", "hello");
  writeFile(folder / "a.vdb", "hello");
  EXPECT_THAT(errorOf([&] { openVolume((folder / "a.txt").string()); }),
              AllOf(HasSubstr("a.txt: unknown kind of file"),
                    HasSubstr("NRRD, MetaImage, NIfTI, VTK"), HasSubstr("OpenVDB")));
  EXPECT_THAT(errorOf([&] { openVolume((folder / "empty").string()); }),
              HasSubstr("unknown kind of file"));
  EXPECT_THAT(errorOf([&] { openVolume((folder / "none.nii").string()); }), HasSubstr("none.nii"));
  EXPECT_THAT(errorOf([&] { openVolume((folder / "a.nrrd").string()); }), HasSubstr("a.nrrd"));
  EXPECT_THAT(errorOf([&] { openVolume((folder / "a.vdb").string()); }),
              HasSubstr("not an OpenVDB file"));
  EXPECT_THAT(errorOf([&] { openVolume(folder.path().string()); }), HasSubstr("has no slices"));
  EXPECT_THAT(errorOf([&] { openVolume((folder / "*.png").string()); }),
              HasSubstr("no file matches"));
}

TEST(OpenVolume, opensTheRealVolumes) {
  struct Known {
    const char* name;
    Vec3i dims;
    VoxelType type;
    int64_t steps;
  };
  for (const Known& known :
       {Known{"bonsai.nii.gz", {256, 256, 256}, VoxelType::kU8, 1},
        Known{"engine_256x256x128_uint8.raw", {256, 256, 128}, VoxelType::kU8, 1},
        Known{"HeadMRVolume.mhd", {48, 62, 42}, VoxelType::kU8, 1},
        Known{"tooth/tooth.nhdr", {103, 94, 161}, VoxelType::kU16, 1},
        Known{"smoke.vdb", {113, 224, 114}, VoxelType::kF32, 1},
        Known{"cthead/%03d.tif", {256, 256, 99}, VoxelType::kU8, 1},
        Known{"viscous-fingers/step_%03d.nrrd", {64, 64, 64}, VoxelType::kF32, 40}}) {
    SCOPED_TRACE(known.name);
    const std::string path = fmt::format("{}/{}", SLUICE_DATA_DIR, known.name);
    if (!std::filesystem::exists(path) &&
        !std::filesystem::exists(std::filesystem::path(path).parent_path()))
      GTEST_SKIP() << path << " is missing";
    const auto source = openVolume(path);
    EXPECT_EQ(source->layout().dims, known.dims);
    EXPECT_EQ(source->layout().type, known.type);
    EXPECT_EQ(source->layout().time_steps, known.steps);
  }
}

}  // namespace
}  // namespace sluice
