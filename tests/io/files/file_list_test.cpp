#include "io/files/file_list.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/io/image_test_support.h"

namespace sluice {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> namesOf(const std::vector<std::filesystem::path>& paths) {
  std::vector<std::string> names;
  for (const auto& path : paths) names.push_back(path.filename().string());
  return names;
}

TEST(NaturalOrder, comparesRunsOfDigitsAsNumbers) {
  std::vector<std::string> names{
      "b1", "a10", "a2", "a1x", "a1", "a", "a02b3", "a2b10", "a123456789012345678901", "a99"};
  std::sort(names.begin(), names.end(), naturalLess);
  EXPECT_THAT(names, ElementsAre("a", "a1", "a1x", "a2", "a02b3", "a2b10", "a10", "a99",
                                 "a123456789012345678901", "b1"));
}

TEST(NaturalOrder, isStrictForNumbersThatDifferByZerosOnly) {
  EXPECT_NE(naturalLess("a01", "a1"), naturalLess("a1", "a01"));
  EXPECT_FALSE(naturalLess("a01", "a01"));
}

TEST(Pattern, globsInNaturalOrder) {
  const TempFolder folder;
  for (const char* name : {"s-10.png", "s-9.png", "s-1.png", "t-3.png", "s-2.txt"})
    writeFile(folder / name, "");
  EXPECT_THAT(namesOf(expandPattern((folder / "s-*.png").string())),
              ElementsAre("s-1.png", "s-9.png", "s-10.png"));
}

TEST(Pattern, takesPrintfNumbersWithGaps) {
  const TempFolder folder;
  for (const char* name :
       {"s_000.raw", "s_100.raw", "s_020.raw", "s_1000.raw", "s_7.raw", "s_x.raw", "s_0100.raw"})
    writeFile(folder / name, "");
  EXPECT_THAT(namesOf(expandPattern((folder / "s_%03d.raw").string())),
              ElementsAre("s_000.raw", "s_020.raw", "s_100.raw", "s_1000.raw"));
  EXPECT_THAT(namesOf(expandPattern((folder / "s_%d.raw").string())),
              ElementsAre("s_7.raw", "s_100.raw", "s_1000.raw"));
}

TEST(Pattern, takesHashesForDigitsAsOutputsDo) {
  const TempFolder folder;
  for (const char* name : {"s_000.raw", "s_100.raw", "s_1000.raw", "s_7.raw", "s_x.raw"})
    writeFile(folder / name, "");
  EXPECT_TRUE(isPattern((folder / "s_###.raw").string()));
  EXPECT_THAT(namesOf(expandPattern((folder / "s_###.raw").string())),
              ElementsAre("s_000.raw", "s_100.raw", "s_1000.raw"));
  EXPECT_THAT(namesOf(expandPattern((folder / "s_#.raw").string())),
              ElementsAre("s_7.raw", "s_100.raw", "s_1000.raw"));
  EXPECT_FALSE(isPattern((folder / "#_##.raw").string()));
  EXPECT_FALSE(isPattern((folder / "#_%d.raw").string()));
  writeFile(folder / "a#1.raw", "");
  EXPECT_FALSE(isPattern((folder / "a#1.raw").string()));
}

TEST(Pattern, namesFoldersAndFilesInThem) {
  const TempFolder folder;
  for (const char* name : {"t_0.zarr", "t_1.zarr", "t_3.zarr", "t_x.zarr", "#1"})
    std::filesystem::create_directory(folder / name);
  for (const char* name : {"t_0.zarr/a", "t_3.zarr/a", "#1/s_1.raw"}) writeFile(folder / name, "");
  EXPECT_THAT(namesOf(expandPattern((folder / "t_#.zarr").string())),
              ElementsAre("t_0.zarr", "t_1.zarr", "t_3.zarr"));
  EXPECT_TRUE(isPattern((folder / "t_%d.zarr/a").string()));
  EXPECT_THAT(expandPattern((folder / "t_%d.zarr/a").string()),
              ElementsAre(folder / "t_0.zarr/a", folder / "t_3.zarr/a"));
  // A folder may have a number sign in its own name.
  EXPECT_THAT(namesOf(expandPattern((folder / "#1/s_#.raw").string())), ElementsAre("s_1.raw"));
  EXPECT_FALSE(isPattern((folder / "t_#/s_#.raw").string()));
}

TEST(NumbersOf, areThoseOfFilesThatDifferInOneNumber) {
  EXPECT_THAT(numbersOf({"s_1001_2.raw", "s_1002_2.raw", "s_1004_2.raw"}),
              ElementsAre(1001, 1002, 1004));
  EXPECT_THAT(numbersOf({"a.raw", "b.raw"}), IsEmpty());
  EXPECT_THAT(numbersOf({"s_1.raw", "s_3.raw", "s_2.raw"}), IsEmpty());
  EXPECT_THAT(numbersOf({"s_1.raw"}), IsEmpty());
}

TEST(ListFolder, hidesNoDeviceAndNoLinkToNothing) {
  const TempFolder folder;
  writeFile(folder / "a.raw", "1");
  std::filesystem::create_symlink("/dev/zero", folder / "b.raw");
  std::filesystem::create_symlink("none", folder / "c.raw");
  std::filesystem::create_directory(folder / "d.raw");
  writeFile(folder / ".e.raw", "1");
  EXPECT_THAT(namesOf(listFolder(folder.path())), ElementsAre("a.raw", "b.raw", "c.raw"));
}

TEST(Pattern, isNoneWhereAFileIsCalledSo) {
  const TempFolder folder;
  writeFile(folder / "a[1].raw", "");
  writeFile(folder / "b%d.raw", "");
  EXPECT_FALSE(isPattern((folder / "a[1].raw").string()));
  EXPECT_FALSE(isPattern((folder / "b%d.raw").string()));
  EXPECT_TRUE(isPattern((folder / "a[2].raw").string()));
  EXPECT_TRUE(isPattern((folder / "c%d.raw").string()));
  EXPECT_FALSE(isPattern((folder / "100%.raw").string()));
  EXPECT_FALSE(isPattern((folder / "%d-%d.raw").string()));
}

TEST(Pattern, rejectsOneThatMatchesNothing) {
  const TempFolder folder;
  EXPECT_THAT(errorOf([&] { expandPattern((folder / "*.png").string()); }),
              HasSubstr("no file matches"));
  EXPECT_THAT(errorOf([&] { expandPattern((folder / "%d.png").string()); }),
              HasSubstr("no file matches"));
  EXPECT_THAT(errorOf([&] { expandPattern((folder / "no/%d.png").string()); }),
              HasSubstr("cannot be read"));
}

TEST(MissingFile, isTheFirstBetweenOthersElseOneBehind) {
  const auto missing = [](std::vector<std::filesystem::path> files, int64_t count = 1) {
    const auto file = missingFile(files, count);
    return file ? file->string() : "";
  };
  EXPECT_EQ(missing({"d/s_000.raw", "d/s_001.raw", "d/s_002.raw", "d/s_004.raw"}), "d/s_003.raw");
  EXPECT_EQ(missing({"s_0.raw", "s_200.raw", "s_300.raw", "s_600.raw"}), "s_100.raw");
  EXPECT_EQ(missing({"s_8.raw", "s_9.raw"}, 2), "s_11.raw");
  EXPECT_EQ(missing({"s_0100.raw", "s_0200.raw"}), "s_0300.raw");
  EXPECT_EQ(missing({"s_1.raw", "s_2.raw", "s_4.raw", "s_10.raw"}), "s_3.raw");
  EXPECT_EQ(missing({"a.raw", "b.raw", "c.raw"}), "");
  EXPECT_EQ(missing({"s_1.raw", "t_2.raw", "s_3.raw"}), "");
  EXPECT_EQ(missing({"s_1.raw"}), "");
  EXPECT_EQ(missing({"s_8.raw", "s_9.raw"}, INT64_MAX), "");
}

TEST(GapNote, namesWhatIsMissing) {
  const std::vector<std::filesystem::path> few{"s_0.raw", "s_1.raw", "s_2.raw", "s_4.raw"};
  EXPECT_THAT(gapNote(few).value_or(""), HasSubstr(".: s_3.raw is missing; "));
  EXPECT_EQ(gapNote({"s_1.raw", "s_2.raw", "s_4.raw", "s_8.raw"}), std::nullopt);
  // Three of four: two steps are neighbours, and one is missing.
  EXPECT_THAT(gapNote({"q_000.raw", "q_001.raw", "q_003.raw"}).value_or(""),
              HasSubstr("q_002.raw is missing"));
  EXPECT_THAT(gapNote({"q_000.raw", "q_100.raw", "q_300.raw"}).value_or(""),
              HasSubstr("q_200.raw is missing"));
  EXPECT_EQ(gapNote({"q_0.raw", "q_1.raw", "q_7.raw"}), std::nullopt);
  EXPECT_THAT(gapNote({"t8_c1.raw", "t9_c1.raw", "t10_c1.raw", "t12_c1.raw"}).value_or(""),
              HasSubstr("t11_c1.raw is missing"));
  EXPECT_EQ(gapNote({"q_0.raw", "q_3.raw", "q_5.raw"}), std::nullopt);
}

TEST(GapNote, namesTheFirstOfAllGaps) {
  EXPECT_THAT(gapNote({"d/1.tif", "d/2.tif", "d/4.tif", "d/5.tif", "d/6.tif", "d/8.tif", "d/9.tif"})
                  .value_or(""),
              HasSubstr("d: 3.tif and 7.tif are missing; "));
  EXPECT_THAT(gapNote({"s1", "s2", "s3", "s4", "s6", "s9", "s10"}).value_or(""),
              HasSubstr("s5, s7 and s8 are missing"));
  EXPECT_THAT(gapNote({"s1", "s2", "s3", "s9"}).value_or(""),
              HasSubstr("s4, s5, s6, s7 and 1 more are missing"));
}

TEST(GapNote, findsNumbersOfFoldersAndInFrontOfSets) {
  EXPECT_THAT(gapNote({"a/t0/v.raw", "a/t1/v.raw", "a/t3/v.raw"}).value_or(""),
              HasSubstr("a: t2/v.raw is missing"));
  EXPECT_THAT(gapNote({"t0.h5:/a/set", "t1.h5:/a/set", "t3.h5:/a/set"}).value_or(""),
              HasSubstr("t2.h5:/a/set is missing"));
  EXPECT_EQ(missingFile({"a/t0/v.raw", "a/t1/v.raw"}, 1), "a/t2/v.raw");
}

TEST(FileIdentity, changesWithAnyFileOfAList) {
  const TempFolder folder;
  writeFile(folder / "a", "1");
  writeFile(folder / "b", "2");
  const std::vector<std::filesystem::path> files{folder / "a", folder / "b"};
  const std::string before = fileIdentity(files);
  EXPECT_EQ(fileIdentity(files), before);
  writeFile(folder / "b", "22");
  EXPECT_NE(fileIdentity(files), before);
  EXPECT_NE(fileIdentity({folder / "b", folder / "a"}), fileIdentity(files));
}

TEST(LowerExtension, keepsWhatGzipHides) {
  EXPECT_EQ(lowerExtension("/x/A.NII.gz"), ".nii.gz");
  EXPECT_EQ(lowerExtension("a.TIF"), ".tif");
  EXPECT_EQ(lowerExtension("a"), "");
}

}  // namespace
}  // namespace sluice
