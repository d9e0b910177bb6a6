// What `sluice pack` says of the volume that it packs.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/program.h"

namespace sluice {
namespace {

using testing::HasSubstr;

// The store cannot tell later what its source lacked.
TEST(PackedSource, saysWhatIsWorthKnowingOfItsSource) {
  const Program program;
  ASSERT_EQ(program.inFolder("mkdir s").status, 0);
  for (const std::string slice : {"s_1", "s_2", "s_4"})
    ASSERT_EQ(program.run("render synth:cube,dims=8x8x8 --size 8 -q -o s/" + slice + ".png").status,
              0);
  const CommandResult packed = program.run("pack s -o s.zarr");
  EXPECT_EQ(packed.status, 0) << packed.output;
  EXPECT_THAT(packed.output, HasSubstr("s_3.png is missing"));
  EXPECT_EQ(program.run("pack s -o quiet.zarr -q").output, "");
}

// The scaling of the values is told, and kept where xarray reads it.
TEST(PackedSource, aScalingOfTheValuesIsTold) {
  const Program program;
  std::string voxels(8 * 8 * 8, '\0');
  for (size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<char>(i % 50);
  writeFile(program.folder / "v.mha",
            "ObjectType = Image\nNDims = 3\nDimSize = 8 8 8\nElementType = MET_UCHAR\n"
            "ElementToIntensityFunctionSlope = 0.5\nElementToIntensityFunctionOffset = 10\n"
            "ElementDataFile = LOCAL\n" +
                voxels);
  const auto range = program.json("info v.mha")["value_range"];
  for (const char* version : {"2", "3"}) {
    const CommandResult packed =
        program.run(fmt::format("pack v.mha -o v{0}.zarr --zarr {0}", version));
    EXPECT_EQ(packed.status, 0) << packed.output;
    EXPECT_THAT(packed.output, HasSubstr("holds the stored numbers; values are these * 0.5 + 10"));
    EXPECT_EQ(program.run(fmt::format("pack v.mha -o q{0}.zarr --zarr {0} -q", version)).output,
              "");
    EXPECT_EQ(program.json(fmt::format("info v{}.zarr", version))["value_range"], range);
    // The array by itself has the scaling, too, and no scaling is applied twice.
    ASSERT_EQ(program.inFolder(fmt::format("cp -r v{0}.zarr/0 a{0}.zarr", version)).status, 0);
    for (const char* array : {"v{}.zarr/0", "a{}.zarr"})
      EXPECT_EQ(program.json("info " + fmt::format(fmt::runtime(array), version))["value_range"],
                range);
  }
  EXPECT_THAT(program.run("pack synth:cube,dims=9x9x9 -o c.zarr").output,
              testing::Not(HasSubstr("stored numbers")));
  EXPECT_FALSE(program.exists("c.zarr/0/.zattrs"));
  if (runCommand("/usr/bin/python3 -c 'import xarray, zarr'").status != 0) return;
  const CommandResult read = program.inFolder(
      "/usr/bin/python3 -c 'import xarray; "
      "a = xarray.open_zarr(\"v2.zarr\", consolidated=False)[\"0\"]; "
      "print(a.dims, float(a.max()))'");
  EXPECT_EQ(read.output, "('z', 'y', 'x') 34.5\n");
}

// Arrays of one file may differ in type: their bytes were packed as if they were of one.
TEST(PackedSource, channelsThatDifferAreRefused) {
  const Program program;
  std::string text =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 3\n"
      "SPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 27\n";
  for (const char* array : {"pressure float", "mask unsigned_char"}) {
    text += fmt::format("SCALARS {} 1\nLOOKUP_TABLE default\n", array);
    for (int i = 0; i < 27; ++i) text += fmt::format("{}\n", i);
  }
  writeFile(program.folder / "v.vtk", text);
  const CommandResult packed = program.run("pack v.vtk -o v.zarr");
  EXPECT_EQ(packed.status, 1);
  EXPECT_THAT(packed.output,
              HasSubstr("v.vtk: channel 1 has voxels of u8, the first of f32: a store has channels "
                        "that are alike; pack each with --channel\n"));
  EXPECT_FALSE(program.exists("v.zarr.partial"));
  EXPECT_EQ(program.run("pack v.vtk -o m.zarr --channel mask").status, 0);
}

// Each channel's index was opened with all of the warnings.
TEST(PackedSource, aWarningOfSeveralChannelsIsPrintedOnce) {
  const Program program;
  std::string voxels;
  for (int i = 0; i < 3 * 4 * 4 * 4; ++i) {
    const double value = 1e9 + i * 1e-3;
    voxels.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  std::filesystem::create_directories(program.folder / "v.zarr");
  writeFile(program.folder / "v.zarr/.zarray",
            R"({"zarr_format": 2, "shape": [3, 4, 4, 4], "chunks": [3, 4, 4, 4], "dtype": "<f8",
                "compressor": null, "fill_value": 0, "order": "C", "filters": null})");
  writeFile(program.folder / "v.zarr/.zattrs", R"({"_ARRAY_DIMENSIONS": ["c", "z", "y", "x"]})");
  writeFile(program.folder / "v.zarr/0.0.0.0", voxels);
  const CommandResult packed = program.run("pack v.zarr -o p.zarr");
  EXPECT_EQ(packed.status, 0);
  const std::string warning = "its doubles are drawn as floats";
  const size_t first = packed.output.find(warning);
  ASSERT_NE(first, std::string::npos) << packed.output;
  EXPECT_EQ(packed.output.find(warning, first + 1), std::string::npos) << packed.output;
}

}  // namespace
}  // namespace sluice
