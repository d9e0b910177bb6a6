#include "io/stores/zip_store.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "io/open_volume.h"
#include "src/base/error.h"
#include "tests/io/python_volumes.h"
#include "tests/io/zarr/zarr_case.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

struct ZipCase : ZarrCase {
  static constexpr const char* kScript = "make_zips.py";
};

class Zip : public PythonVolumesTest<ZipCase> {
 protected:
  static std::string read(const fs::path& zip) {
    const auto source = openVolume(zip.string());
    return allSteps(*source);
  }
  // A zip file of these bytes.
  fs::path zipOf(const std::string& bytes, const std::string& name = "a.zip") const {
    std::ofstream(folder_of_test_ / name, std::ios::binary) << bytes;
    return folder_of_test_ / name;
  }

  const TempFolder folder_of_test_;
};

TEST_F(Zip, storesAreReadAsTheyWereWritten) {
  ASSERT_EQ(cases_.size(), 11U);
  for (const ZipCase& c : cases_) {
    SCOPED_TRACE(c.name);
    const auto source = openVolume(pathOf(c.name).string());
    EXPECT_EQ(source->layout().dims, c.dims);
    const std::string whole = voxelsOf(c.name);
    EXPECT_TRUE(allSteps(*source) == whole);
    expectBoxesAreParts(*source, whole);
  }
}

TEST_F(Zip, aFolderInsideIsNamedBehindAColon) {
  const std::string zip = pathOf("one_folder.zarr.zip").string();
  EXPECT_TRUE(read(zip + ":/volume.zarr") == voxelsOf("one_folder.zarr.zip"));
  EXPECT_THAT(errorOf([&] { read(zip + ":/other"); }),
              AllOf(HasSubstr("one_folder.zarr.zip/other"), HasSubstr("in the zip file")));
}

TEST_F(Zip, keysAreThoseOfItsEntries) {
  ZipStore store(pathOf("one_folder.zarr.zip"));
  EXPECT_TRUE(store.has("volume.zarr"));
  EXPECT_TRUE(store.has("volume.zarr/0/../.zarray"));
  EXPECT_FALSE(store.has("volume"));
  EXPECT_FALSE(store.has("volume.zarr/9"));
  std::vector<std::string> names;
  store.list("volume.zarr", [&](const ChunkStore::Entry& entry) {
    names.push_back(entry.name + (entry.is_folder ? "/" : ""));
  });
  EXPECT_THAT(names, ElementsAre(".zarray", "0/", "1/", "2/"));
}

// Parts of an entry, stored or deflated, are those of the whole.
TEST_F(Zip, partsAreThoseOfTheWhole) {
  for (const auto& [zip, key] :
       {std::pair("stored.zip", "1/1/1"), {"one_folder.zarr.zip", "volume.zarr/1/1/1"}}) {
    ZipStore store(pathOf(zip));
    const auto partOf = [&, key = key](const PieceBytes& wanted) {
      std::string bytes;
      EXPECT_TRUE(store.read(key, wanted, [&](const PieceInfo& piece) {
        bytes.resize(wanted.from == PieceBytes::From::kAll ? piece.bytes : wanted.bytes);
        return std::as_writable_bytes(std::span(bytes));
      }));
      return bytes;
    };
    const std::string whole = partOf({});
    ASSERT_EQ(whole.size(), 240U);
    EXPECT_EQ(partOf({PieceBytes::From::kStart, 100, 40}), whole.substr(100, 40));
    EXPECT_EQ(partOf({PieceBytes::From::kStart, 240, 0}), "");
    EXPECT_EQ(partOf({PieceBytes::From::kEnd, 0, 16}), whole.substr(224));
    EXPECT_THAT(errorOf([&] {
                  partOf({PieceBytes::From::kStart, 230, 11});
                }),
                AllOf(HasSubstr(zip), HasSubstr("found 240")));
    EXPECT_THAT(errorOf([&] { partOf({PieceBytes::From::kEnd, 0, 241}); }), HasSubstr("found 240"));
  }
}

// A flipped bit is found, or makes no difference, or changes a name in the list of files: then the
// store lacks that chunk.
TEST_F(Zip, damageIsFound) {
  for (const char* name : {"stored.zip", "deflated.zip", "wide.zip"}) {
    const std::string whole = readFile(pathOf(name)), voxels = voxelsOf(name);
    const size_t list_at = whole.find("PK\1\2");
    int found = 0;
    for (size_t at = 0; at < whole.size(); at += 7) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << (at % 8)));
      try {
        const auto source = openVolume(zipOf(damaged).string());
        const bool is_whole = allSteps(*source) == voxels;
        const bool lacks_chunks = at > list_at && source->occupancy(0).has_value();
        EXPECT_TRUE(is_whole || lacks_chunks) << name << " at " << at;
      } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("a.zip"));
        EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
        ++found;
      }
    }
    EXPECT_GT(found, 100) << name;
  }
}

TEST_F(Zip, aWrongCountOrPlaceOfEntriesIsFound) {
  std::string fewer = readFile(pathOf("stored.zip"));
  fewer[fewer.rfind("PK\5\6") + 10] = 20;
  EXPECT_THAT(errorOf([&] { read(zipOf(fewer)); }),
              AllOf(HasSubstr("a.zip: expected 20 entries"), HasSubstr("found 28")));
  // The places of two chunks in the list, one for the other.
  std::string turned = readFile(pathOf("stored.zip"));
  const size_t list_at = turned.find("PK\1\2");
  const size_t one = turned.find("0/0/1", list_at) - 4, other = turned.find("0/1/0", list_at) - 4;
  std::swap_ranges(&turned[one], &turned[one] + 4, &turned[other]);
  EXPECT_THAT(errorOf([&] { read(zipOf(turned)); }), HasSubstr("expected its header"));
}

// Each part of a long deflated entry would be decoded from its start.
TEST_F(Zip, partsOfLongDeflatedEntriesAreRefused) {
  const std::string folder = shellQuoted(folder_of_test_.path().string());
  ASSERT_EQ(runCommand("cd " + folder +
                       " && /usr/bin/python3 -c 'import zipfile; zipfile.ZipFile(\"long.zip\", "
                       "\"w\", zipfile.ZIP_DEFLATED).writestr(\"0\", bytes(5 << 20))'")
                .status,
            0);
  ZipStore store(folder_of_test_ / "long.zip");
  std::vector<std::byte> bytes(8);
  const auto part = [&] {
    store.read("0", {PieceBytes::From::kEnd, 0, 8},
               [&](const PieceInfo&) { return std::span(bytes); });
  };
  EXPECT_THAT(errorOf(part), AllOf(HasSubstr("long.zip/0"), HasSubstr("without compression")));
}

TEST_F(Zip, namesAVolumeByItsFile) {
  EXPECT_EQ(openVolume(pathOf("stored.zip").string())->layout().name, "stored.zip");
  EXPECT_EQ(openVolume(pathOf("mac.zip").string())->layout().name, "volume.zarr");
}

TEST_F(Zip, filesThatWereCutShortAreRefused) {
  const std::string whole = readFile(pathOf("deflated.zip"));
  for (size_t bytes = 4; bytes < whole.size(); bytes += 97)
    EXPECT_THAT(errorOf([&] { read(zipOf(whole.substr(0, bytes))); }),
                AllOf(HasSubstr("a.zip"), HasSubstr("cut short")))
        << bytes;
}

TEST_F(Zip, refusesWhatItCannotRead) {
  const std::string folder = shellQuoted(folder_of_test_.path().string());
  const std::string begin = "cd " + folder + " && /usr/bin/python3 -c 'import zipfile; ";
  ASSERT_EQ(
      runCommand(begin + "zipfile.ZipFile(\"none.zip\", \"w\").writestr(\"a.txt\", \"b\")'").status,
      0);
  EXPECT_THAT(errorOf([&] { read(folder_of_test_ / "none.zip"); }),
              AllOf(HasSubstr("none.zip: expected a Zarr or N5 store"), HasSubstr("unpack")));
  ASSERT_EQ(
      runCommand(
          begin +
          "zipfile.ZipFile(\"xz.zip\", \"w\", zipfile.ZIP_LZMA).writestr(\".zgroup\", \"{}\")'")
          .status,
      0);
  EXPECT_THAT(errorOf([&] { read(folder_of_test_ / "xz.zip"); }),
              AllOf(HasSubstr("xz.zip/.zgroup"), HasSubstr("method 14")));
  std::string locked = readFile(pathOf("stored.zip"));
  locked[locked.find("PK\1\2") + 8] |= 1;
  EXPECT_THAT(errorOf([&] { read(zipOf(locked)); }), HasSubstr("encrypted"));
  EXPECT_THAT(errorOf([&] { read(zipOf("PK\5\6" + std::string(18, '\0'))); }),
              HasSubstr("expected a Zarr or N5 store"));
}

}  // namespace
}  // namespace sluice
