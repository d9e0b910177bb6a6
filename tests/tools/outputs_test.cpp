// A command's output never replaces its input, another output or, unless it is told to, a file of
// another kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "io/pictures/png_file.h"
#include "tests/tools/program.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

// Folders and files with their contents, except indices and new results.
class Outputs : public testing::Test {
 protected:
  void SetUp() override {
    made("synth shells -o v_24x20x16_uint8.raw --dims 24,20,16 -q");
    made("synth shells -o v.mhd --dims 24,20,16 -q");
    made("synth shells -o v.nhdr --dims 24,20,16 -q --force");
    made("synth shells -o w.nrrd --dims 24,20,16 -q");
    made("pack w.nrrd -o v.zarr -q");
    fs::create_directory(program_.folder / "pngs");
    for (const char* angle : {"10", "20", "30"})
      made("render w.nrrd -q --size 16 --background 000000 -o pngs/s" + std::string(angle) +
           ".png --azimuth " + angle);
    made("render w.nrrd -q -o t.png --size 16 --trace t.trace --report r.json");
    writeFile(program_.folder / "t.json",
              R"({"sluice_transfer_function": 1, "map": "grey", "opacities": [[90, 0.1]]})");
    writeFile(program_.folder / "path.json", R"({"keys": [{"at": 0, "azimuth": 10}]})");
    writeFile(program_.folder / "notes.txt", "my only copy\n");
    writeFile(program_.folder / "photo.png", "GIF89a");
    fs::create_symlink("w.nrrd", program_.folder / "link.png");
    fs::create_hard_link(program_.folder / "w.nrrd", program_.folder / "hard.png");
    fs::create_symlink("pngs", program_.folder / "scan");
    before_ = filesOf(program_.folder.path());
  }
  void made(const std::string& line) {
    const CommandResult result = program_.run(line);
    ASSERT_EQ(result.status, 0) << line << ": " << result.output;
  }
  // Nothing that was there is gone or changed, and nothing new is there.
  void unchanged(const std::string& line) {
    std::map<std::string, std::string> after = filesOf(program_.folder.path());
    std::erase_if(after, [](const auto& file) { return file.first.starts_with("cache/"); });
    std::map<std::string, std::string> expected = before_;
    std::erase_if(expected, [](const auto& file) { return file.first.starts_with("cache/"); });
    EXPECT_TRUE(after == expected) << line;
  }
  void refuses(const std::string& line, const std::string& said) {
    const CommandResult result = program_.run(line);
    EXPECT_EQ(result.status, 1) << line << ": " << result.output;
    EXPECT_TRUE(isOneLine(result.output)) << line << ": " << result.output;
    EXPECT_NE(result.output.find(said), std::string::npos) << line << ": " << result.output;
    unchanged(line);
  }

  const Program program_;
  std::map<std::string, std::string> before_;
};

TEST_F(Outputs, areNeverWhatTheCommandReads) {
  for (const std::string force : {"", " --force"}) {
    const std::string render = "render w.nrrd --size 16" + force;
    refuses(render + " -o link.png", "link.png: is the file w.nrrd");
    refuses(render + " -o hard.png", "hard.png: is the file w.nrrd");
    refuses(render + " -o a.png --report w.nrrd", "--report w.nrrd: is the file w.nrrd");
    refuses(render + " -o a.png --trace ./w.nrrd", "--trace");
    refuses(render + " -o a.png --transfer t.json --report t.json", "is the file t.json");
    refuses(render + " -o a.png --frames 2 --path path.json --report path.json",
            "is the file path.json");
    refuses("render pngs -o pngs/s10.png --size 16" + force, "pngs/s10.png");
    refuses("render pngs -o scan/new.png --size 16" + force, "lies in pngs");
    refuses("render pngs/s10.png pngs/s20.png pngs/s30.png -o pngs/s20.png --size 16" + force,
            "is the file pngs/s20.png");
    refuses("render 'pngs/s*.png' -o pngs/s20.png --size 16" + force, "is the file pngs/s20.png");
    refuses("render v.mhd -o a.png --size 16 --report v.raw" + force, "is the file v.raw");
    refuses("render v.nhdr -o a.png --size 16 --trace v.raw" + force, "is the file v.raw");
    refuses("render v.zarr -o v.zarr/a.png --size 16" + force, "lies in v.zarr");
    refuses("render v.zarr -o a.png --size 16 --report v.zarr/0/.zarray" + force, "v.zarr");
    refuses("simulate t.trace --csv t.trace" + force, "is the file t.trace");
    refuses("simulate t.trace --export t.trace" + force, "is the file t.trace");
    refuses("simulate w.nrrd --frames 2 --html w.nrrd" + force, "is the file w.nrrd");
    refuses("plan w.nrrd --transfer t.json --report t.json" + force, "is the file t.json");
    refuses("simulate t.trace --report t.trace" + force, "is the file t.trace");
    refuses(render + " -o a.png --culling pof --basis t.json --report t.json",
            "is the file t.json");
    refuses("bench report r.json t.json -o t.json" + force, "is the file t.json");
    refuses("pack v.zarr -o v.zarr" + force, "is the file v.zarr");
    refuses("pack v.zarr -o v.zarr/b.zarr" + force, "lies in v.zarr");
  }
}

TEST_F(Outputs, neverLieInAnN5Store) {
  const std::string attributes =
      R"({"dimensions": [4, 4, 4], "blockSize": [4, 4, 4], "dataType": "uint8",)"
      R"( "compression": {"type": "raw"}})";
  // A data set, and a group of levels whose attributes are missing.
  fs::create_directories(program_.folder / "v.n5");
  fs::create_directories(program_.folder / "g.n5" / "s0");
  writeFile(program_.folder / "v.n5" / "attributes.json", attributes);
  writeFile(program_.folder / "g.n5" / "s0" / "attributes.json", attributes);
  before_ = filesOf(program_.folder.path());
  for (const std::string force : {"", " --force"})
    for (const std::string store : {"v.n5", "g.n5"}) {
      const std::string report = "plan " + store + " --range=0,255 --report " + store;
      refuses(report + "/plan.json" + force, "lies in " + store);
    }
}

TEST_F(Outputs, ofBenchesAreNeitherWhatTheyReadNorWhatIsNoReport) {
  const std::string bench = "bench render w.nrrd --frames 1 --size 16 --report ";
  refuses(bench + "t.json --transfer t.json", "is the file t.json");
  refuses(bench + "w.nrrd", "is the file w.nrrd");
  refuses("bench render v.mhd --frames 1 --size 16 --report v.raw",
          "v.raw: exists and is not a report of sluice");
  refuses("bench render v.zarr --frames 1 --size 16 --report v.zarr/.zattrs", "lies in v.zarr");
  refuses("bench slicing --report notes.txt",
          "notes.txt: exists and is not a report of sluice; give another name");
}

TEST_F(Outputs, withoutAPlaceAreRefusedBeforeTheVolumeIsRead) {
  fs::copy_file(program_.folder / "w.nrrd", program_.folder / "new.nrrd");
  before_ = filesOf(program_.folder.path());
  const std::string letters(252, 'a'), render = "render new.nrrd --size 16 ";
  const auto refusesUnread = [&](const std::string& line, const std::string& said) {
    refuses(line, said);
    // Its index would be kept.
    const auto after = filesOf(program_.folder.path());
    EXPECT_EQ(after.size(), before_.size()) << line;
  };
  refusesUnread(render + "-o " + letters + ".png", "cannot be written: File name too long");
  refusesUnread(render + "-o a.png --report " + letters + ".json", "File name too long");
  refusesUnread(render + "-o a.png --trace " + letters + ".txt", "File name too long");
  refusesUnread(render + "-o a.png --occlusion map --debug-view --report " + letters + ".html",
                "File name too long");
  refusesUnread(render + "--frames 20 -o " + letters.substr(2) + ".png", "File name too long");
  refusesUnread("surface new.nrrd --iso 90 -o " + letters + ".stl", "File name too long");
  refusesUnread(render + "-o nowhere/a.png", "nowhere/a.png: cannot be written: No such file");
  refusesUnread(render + "-o a.png --report w.nrrd/r.json", "cannot be written: Not a directory");
  // The longest name that fits.
  made(render + "-o " + letters.substr(1) + ".png");
}

// `--csv -` prints, so that `-` as another output would be a surprising file.
TEST_F(Outputs, calledAHyphenAreRefused) {
  const std::string picture = std::string("render ") + kSmall + " --size 16 -q -o a.png ";
  ASSERT_EQ(program_.run(picture + "--trace t.txt").status, 0);
  for (const std::string& line :
       {picture + "--force --report -", picture + "--force --trace -",
        std::string("simulate t.txt --html -"), std::string("simulate t.txt --export -")}) {
    const CommandResult result = program_.run(line);
    EXPECT_EQ(result.status, 1) << line;
    EXPECT_TRUE(isOneLine(result.output)) << result.output;
    EXPECT_NE(result.output.find(" -: expected the name of a file"), std::string::npos)
        << result.output;
  }
  EXPECT_FALSE(program_.exists("-"));
  EXPECT_EQ(program_.run(picture + "--force --report ./-").status, 0);
  EXPECT_TRUE(program_.exists("-"));
  EXPECT_EQ(program_.run("simulate t.txt --csv -").status, 0);
}

TEST_F(Outputs, areNeverOneAnother) {
  const std::string render = "render w.nrrd --size 16 -o a.png ";
  refuses(render + "--report a.png", "is the same file as -o a.png");
  refuses(render + "--report b --trace ./b", "is the same file as --report b");
  refuses(render + "--frames 3 --report a_001.png", "is the same file as -o a_001.png");
  refuses(render + "--debug-view --partition boxes --report a.boxes.png", "a.boxes.png");
  refuses("simulate t.trace --csv c --html ./c", "is the same file as");
  fs::create_symlink("a.png", program_.folder / "to_be.json");
  before_ = filesOf(program_.folder.path());
  refuses(render + "--report to_be.json", "is the same file as -o a.png");
}

TEST_F(Outputs, replaceWhatIsOfTheirKindAndAnythingElseByForceAlone) {
  const std::string render = "render w.nrrd --size 16 -q ";
  refuses(render + "-o photo.png", "photo.png: exists and is not a PNG picture of sluice; --force");
  refuses(render + "-o a.png --report notes.txt",
          "notes.txt: exists and is not a report of sluice; --force");
  refuses(render + "-o a.png --trace v.raw", "v.raw: exists and is not a trace of sluice; --force");
  refuses("simulate t.trace --html notes.txt", "exists and is not a page of sluice");
  refuses("simulate t.trace --csv v.raw", "exists and is not a table of sluice");
  refuses("synth cube --dims 8,8,8 -o v_24x20x16_uint8.raw", "--force");
  fs::rename(program_.folder / "v.raw", program_.folder / "x.raw");
  before_ = filesOf(program_.folder.path());
  refuses("synth cube --dims 8,8,8 -o x.mhd", "x.raw: exists");
  made(render + "-o t.png --report r.json --trace t.trace");
  made(render + "-o photo.png --report notes.txt --force");
  EXPECT_NO_THROW(readPng(program_.folder / "photo.png"));
  made("synth cube --dims 8,8,8 -o x.mhd -q --force");
  made("synth cube --dims 8,8,8 -o w.nrrd -q");
  made(render + "-o z.png --report /dev/null --trace /dev/null");
}

// Files of a user's own that a kind of output might be taken for.
const std::map<std::string, std::string>& othersFiles() {
  using namespace std::string_literals;
  static const std::map<std::string, std::string> files = {
      {"package.json", R"({"name": "viewer", "version": "1.0.0", "sluice": "^1"})"},
      {"nested.json", R"({"a": {"sluice": "report"}})"},
      {"list.json", R"([{"sluice": "report"}])"},
      {"damaged.json", R"({"sluice": )"},
      {"look.json", R"({"sluice_transfer_function": 1, "map": "grey"})"},
      {"view.json", R"({"sluice": "view"})"},
      {"site.html", "<!DOCTYPE html>\n<html><head><title>Mine</title></head></html>\n"},
      {"notes.md", "# sluice 0.1\n\n1 2 3\n"},
      {"script.sh", "#!/bin/sh\nsluice render a.nrrd\n"},
      {"table.csv", "policy,premium\nhome,12\n"},
      {"trace.csv", "time,obj_id,obj_size\n0,1,4096\n"},
      {"trace.oracleGeneral", std::string(48, '\1')},
      {"trace.din", "0 1000\n0 2000\n"},
      {"scan.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\n\n\7"},
      {"scan.mhd", "ObjectType = Image\nElementDataFile = scan.bin\n"},
      {"photo.png", "\x89PNG\r\n\x1a\n\0\0\0\rIHDR and the rest"s},
      {"plate.exr", "\x76\x2f\x31\x01 and the rest"s},
      {"voxels.raw", "\1\2\3"}};
  return files;
}

// Every option that names a file to write, and the file that it wrote before.
TEST_F(Outputs, replaceAFileOnlyIfSluiceWroteItAsTheSameKind) {
  const std::string render = "render w.nrrd --size 16 -q ", simulate = "simulate t.trace -q ";
  struct Case {
    std::string command, name;
  };
  const std::vector<Case> cases = {{render + "-o", "a.png"},
                                   {render + "-o", "a.exr"},
                                   {render + "-o z.png --report", "a_report.json"},
                                   {render + "-o z.png --report", "a.html"},
                                   {render + "-o z.png --trace", "b.trace"},
                                   {render + "-o z.png --trace", "b.txt"},
                                   {render + "-o z.png --trace", "b.csv"},
                                   {render + "-o z.png --trace", "b.din"},
                                   {render + "-o z.png --trace", "b.oracleGeneral"},
                                   {simulate + "--html", "c.html"},
                                   {simulate + "--report", "c.json"},
                                   {simulate + "--csv", "c.csv"},
                                   {simulate + "--export", "d.trace"},
                                   {simulate + "--export", "d.oracleGeneral"},
                                   {"plan w.nrrd --report", "e.json"},
                                   {"bench slicing --report", "f.json"},
                                   {"synth cube --dims 4,4,4 -q -o", "g.nrrd"}};
  for (const auto& [command, name] : cases) {
    made(command + " " + name);
    made(command + " " + name);  // its own is replaced
    // A name of its own kind leads a writer to the same format.
    const fs::path target = program_.folder / ("taken" + fs::path(name).extension().string());
    for (const auto& [other, content] : othersFiles()) {
      writeFile(target, content);
      before_ = filesOf(program_.folder.path());
      refuses(command + " " + target.filename().string(),
              target.filename().string() + ": exists and is not");
    }
    fs::remove(target);
  }
  // Nor does one kind of ours replace another.
  before_ = filesOf(program_.folder.path());
  refuses(render + "-o z.png --report t.json", "t.json: exists");
  refuses(simulate + "--csv b.csv", "b.csv: exists and is not a table of sluice");
  refuses(simulate + "--export c.csv", "c.csv: exists and is not a trace of sluice");
  // The second file of a format counts too.
  writeFile(program_.folder / "x.oracleGeneral.sluice", "my only copy\n");
  before_ = filesOf(program_.folder.path());
  refuses(simulate + "--export x.oracleGeneral", "x.oracleGeneral.sluice: exists");
}

TEST_F(Outputs, aStoreIsReplacedOnlyWhenNothingElseIsInIt) {
  refuses("pack v.nhdr -o v.zarr", "--force");
  made("pack v.nhdr -o v.zarr --force -q");
  writeFile(program_.folder / "v.zarr" / "0" / "thesis.txt", "my only copy");
  before_ = filesOf(program_.folder.path());
  refuses("pack v.nhdr -o v.zarr --force", "thesis.txt");
  fs::create_directory(program_.folder / "mine.zarr");
  writeFile(program_.folder / "mine.zarr" / "letter.txt", "my only copy");
  before_ = filesOf(program_.folder.path());
  refuses("pack v.nhdr -o mine.zarr --force", "mine.zarr");
}

// Whoever reads the file believes its name.
TEST_F(Outputs, ofRawVoxelsHaveNoNameThatIsNotTrue) {
  for (const std::string name : {"z_16x8x8_uint8.raw", "z_8x8x8_uint16.raw", "z_8x8x8x2_u8.raw"}) {
    const CommandResult refused = program_.run("synth cube --dims 8,8,8 -o " + name);
    EXPECT_EQ(refused.status, 1) << name;
    EXPECT_TRUE(isOneLine(refused.output)) << refused.output;
    EXPECT_THAT(refused.output, HasSubstr(name + ": the name says "));
    EXPECT_FALSE(program_.exists(name));
  }
  EXPECT_EQ(program_.run("synth cube --dims 8,8,8 --type u16 -q -o z_16x8x8_uint8.mhd").status, 1);
}

TEST_F(Outputs, carryTheVeryNameThatWasGiven) {
  const std::string render = "render w.nrrd --size 16 -q ";
  made("synth cube --dims 8,8,8 -q -o x_8x8x8_uint8.raw");
  EXPECT_EQ(fs::file_size(program_.folder / "x_8x8x8_uint8.raw"), 512U);
  const CommandResult bare = program_.run("synth cube --dims 8,8,8 -o bare.raw");
  EXPECT_EQ(fs::file_size(program_.folder / "bare.raw"), 512U);
  EXPECT_NE(bare.output.find("--dims 8,8,8 --type u8"), std::string::npos) << bare.output;
  made(render + "-o UPPER.PNG");
  EXPECT_NO_THROW(readPng(program_.folder / "UPPER.PNG"));
  made(render + "-o h_####.png --frames 2");
  made(render + "-o p_%04d.png --frames 2");
  for (const char* name : {"h_0000.png", "h_0001.png", "p_0000.png", "p_0001.png"})
    EXPECT_TRUE(program_.exists(name)) << name;
  made("synth flow --dims 16,16,16 --steps 3 -q -o f_16x16x16_uint8_##.raw");
  made("render 'f_16x16x16_uint8_%02d.raw' --time 2 --size 16 -q -o step_###.png");
  EXPECT_TRUE(program_.exists("step_002.png")) << "numbered by the step";
}

TEST_F(Outputs, quietLeavesErrorsAlone) {
  EXPECT_EQ(program_.run("render w.nrrd --size 16 -o q.png -q").output, "");
  EXPECT_EQ(program_.run("info w.nrrd -q").output, "");
  EXPECT_NE(program_.run("info none.nrrd -q").output, "");
}

}  // namespace
}  // namespace sluice
