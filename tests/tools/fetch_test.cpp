#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>

#include "tests/io/web/web_server.h"
#include "tests/tools/program.h"
#include "tools/fetch/named_volumes.h"

namespace sluice {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Pieces of 8 MiB come several at once and end together. Once the first ones are there, others are
// still on their way.
constexpr size_t kEnoughForTwoRounds = size_t{56} << 20;

class FetchProgram : public testing::Test {
 protected:
  // A file of several pieces behind a line of 100 Mbit/s.
  void makeFile(size_t bytes) {
    std::mt19937 random(3);
    content_.resize(bytes);
    for (char& c : content_) c = static_cast<char>(random());
    std::ofstream(served_ / "head_256x256x256_uint16.raw", std::ios::binary) << content_;
  }
  std::string fileOf(const Program& program) const {
    return readFile(program.folder / "head_256x256x256_uint16.raw");
  }

  const TempFolder served_;
  std::string content_;
  const Program program_;
};

// A profile that is not there matters to buckets alone.
TEST_F(FetchProgram, looksForAKeyOnlyIfABucketIsNamed) {
  makeFile(1000);
  const WebServer server(served_.path());
  const std::string file = "/head_256x256x256_uint16.raw";
  setenv("AWS_PROFILE", "nobody", 1);
  const CommandResult plain = program_.run("fetch -q " + server.address() + file);
  const CommandResult bucket = program_.run("fetch -q s3://bucket" + file);
  unsetenv("AWS_PROFILE");
  EXPECT_EQ(plain.status, 0) << plain.output;
  EXPECT_EQ(bucket.status, 1);
  EXPECT_THAT(bucket.output, HasSubstr("AWS_PROFILE: no profile nobody"));
}

TEST_F(FetchProgram, copiesAFileByItsAddress) {
  makeFile(100000);
  const WebServer server(served_.path());
  const std::string address = server.address() + "/head_256x256x256_uint16.raw";
  const CommandResult done = program_.run("fetch " + address);
  EXPECT_EQ(done.status, 0) << done.output;
  EXPECT_THAT(done.output, AllOf(HasSubstr("Terms: those of its publisher"), HasSubstr("SHA-256")));
  EXPECT_TRUE(fileOf(program_) == content_);
  const CommandResult again = program_.run("fetch " + address);
  EXPECT_EQ(again.status, 1);
  EXPECT_TRUE(again.output.find("--force replaces it") != std::string::npos) << again.output;
  const auto report = program_.json("fetch --force " + address);
  EXPECT_EQ(report["bytes"], 100000);
  const CommandResult wrong =
      program_.run("fetch -q -o x.raw --sha256 " + std::string(64, '0') + " " + address);
  EXPECT_EQ(wrong.status, 1);
  EXPECT_TRUE(isOneLine(wrong.output)) << wrong.output;
  EXPECT_FALSE(program_.exists("x.raw"));
  EXPECT_EQ(
      program_
          .run("fetch -q -o y.raw --sha256 " + report["sha256"].get<std::string>() + " " + address)
          .status,
      0);
}

TEST_F(FetchProgram, goesOnAfterItWasKilled) {
  makeFile(kEnoughForTwoRounds);
  const WebServer server(served_.path(), "shaped");
  const std::string address = server.address() + "/head_256x256x256_uint16.raw";
  program_.signalled("fetch -q " + address, "KILL",
                     "test $(stat -c %s head_256x256x256_uint16.raw.part || echo 0) -gt 9000000");
  EXPECT_FALSE(program_.exists("head_256x256x256_uint16.raw"));
  ASSERT_TRUE(program_.exists("head_256x256x256_uint16.raw.part"));
  const auto report = program_.json("fetch " + address);
  EXPECT_GT(report["resumed_bytes"].get<uint64_t>(), 8000000U);
  EXPECT_TRUE(fileOf(program_) == content_);
  uint64_t whole = 0;
  for (const WebRequest& r : server.requests())
    if (r.status == 206) whole += r.bytes;
  // Only the pieces that were on their way when it was killed come twice.
  EXPECT_LE(whole, content_.size() + (size_t{5} << 23));
}

TEST_F(FetchProgram, endsWithinASecondOfASignalAndGoesOn) {
  makeFile(kEnoughForTwoRounds);
  const WebServer server(served_.path(), "shaped");
  const std::string address = server.address() + "/head_256x256x256_uint16.raw";
  const CommandResult stopped = program_.signalled(
      "fetch -q " + address, "INT",
      "test $(stat -c %s head_256x256x256_uint16.raw.part || echo 0) -gt 9000000");
  EXPECT_EQ(stopped.status, 130) << stopped.output;
  ASSERT_EQ(program_.run("fetch -q " + address).status, 0);
  EXPECT_TRUE(fileOf(program_) == content_);
}

TEST_F(FetchProgram, copiesAStoreThatIsDrawnAlike) {
  const Program at_server;
  ASSERT_EQ(at_server
                .run("pack synth:shells,dims=90x80x70 -q -o v.zarr --zarr 3 --chunk 32 "
                     "--shard 64,64,64 --levels auto")
                .status,
            0);
  const WebServer server(at_server.folder.path());
  const CommandResult done = program_.run("fetch " + server.address() + "/v.zarr");
  EXPECT_EQ(done.status, 0) << done.output;
  const CommandResult same = program_.run("render v.zarr -q -o a.png && cd " +
                                          shellQuoted(at_server.folder.path().string()) +
                                          " && XDG_CACHE_HOME=\"$PWD/cache\" " SLUICE_PROGRAM
                                          " render v.zarr -q -o b.png && cmp b.png " +
                                          shellQuoted((program_.folder / "a.png").string()));
  EXPECT_EQ(same.status, 0) << same.output;
  const CommandResult checked = program_.run("pack --check v.zarr");
  EXPECT_EQ(checked.status, 0) << checked.output;
  EXPECT_EQ(program_.run("fetch " + server.address() + "/v.zarr").status, 1);
  // A folder's name may end by a slash, and the folder around it need not be there.
  const CommandResult slash = program_.run("fetch -q " + server.address() +
                                           "/v.zarr -o new/v.zarr/ && diff -r v.zarr new/v.zarr");
  EXPECT_EQ(slash.status, 0) << slash.output;
}

// Empty folders looked like parts of a store.
TEST_F(FetchProgram, leavesNoEmptyFoldersWhenItFails) {
  const Program at_server;
  ASSERT_EQ(
      at_server.run("pack synth:shells,dims=90x80x70 -q -o v.zarr --zarr 3 --chunk 32").status, 0);
  const WebServer server(at_server.folder.path(), "later");
  const CommandResult failed =
      program_.run("fetch " + server.address() + "/v.zarr -o new/folder/v.zarr");
  EXPECT_EQ(failed.status, 1) << failed.output;
  EXPECT_EQ(program_.inFolder("find . -name cache -prune -o -type d -empty -print").output, "");
  EXPECT_TRUE(program_.exists("new/folder/v.zarr.part/zarr.json"))
      << "the next run goes on with it";
  // A folder that somebody's file has the name of cannot be made.
  writeFile(program_.folder / "file", "mine");
  EXPECT_EQ(program_.run("fetch " + server.address() + "/v.zarr -o file/v.zarr").status, 1);
  EXPECT_EQ(readFile(program_.folder / "file"), "mine");
}

// Nothing is fetched before the terms are accepted: the name's server is not asked.
TEST_F(FetchProgram, showsTheTermsOfANamedVolumeFirst) {
  const CommandResult shown = program_.run("fetch bonsai");
  EXPECT_EQ(shown.status, 1);
  EXPECT_THAT(shown.output, AllOf(HasSubstr("Terms: The Open SciVis collection"),
                                  HasSubstr("--accept-licence"), HasSubstr("16.0 MiB")));
  EXPECT_FALSE(program_.exists("bonsai_256x256x256_uint8.raw.part"));
  const CommandResult unknown = program_.run("fetch bonsia");
  EXPECT_EQ(unknown.status, 1);
  EXPECT_TRUE(isOneLine(unknown.output)) << unknown.output;
  EXPECT_THAT(unknown.output, HasSubstr("did you mean bonsai?"));
  const CommandResult renamed = program_.run("fetch bonsai -o small_16x8x8_uint8.raw");
  EXPECT_EQ(renamed.status, 1);
  EXPECT_TRUE(isOneLine(renamed.output)) << renamed.output;
  EXPECT_THAT(renamed.output, HasSubstr("small_16x8x8_uint8.raw: the name says 16 x 8 x 8 voxels"));
  EXPECT_EQ(program_.run("fetch").status, 2);
  EXPECT_EQ(program_.run("fetch x --sha256 12").status, 2);
}

// The table is that of datasets.md, and each name has the size that its dims and type give.
TEST(NamedVolumes, areTheRowsOfTheDocument) {
  std::ifstream file(SLUICE_SOURCE_DIR "/datasets.md");
  std::map<std::string, std::vector<std::string>> rows;
  bool is_inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) is_inside = line.find("Open SciVis") != std::string::npos;
    if (!is_inside || !line.starts_with("| ") || line.starts_with("| name")) continue;
    std::vector<std::string> cells;
    std::istringstream parts(line.substr(2));
    for (std::string cell; std::getline(parts, cell, '|');)
      cells.push_back(cell.substr(cell.find_first_not_of(' '),
                                  cell.find_last_not_of(' ') - cell.find_first_not_of(' ') + 1));
    rows[cells[0]] = cells;
  }
  EXPECT_EQ(rows.size(), namedVolumes().size());
  for (const NamedVolume& volume : namedVolumes()) {
    SCOPED_TRACE(volume.name);
    const auto found = rows.find(std::string(volume.name));
    ASSERT_NE(found, rows.end());
    const std::vector<std::string>& row = found->second;
    EXPECT_EQ(row[1], volume.what);
    EXPECT_EQ(row[2], fmt::format("{}x{}x{} {}", volume.dims[0], volume.dims[1], volume.dims[2],
                                  volume.type));
    std::string spacing(volume.spacing);
    std::replace(spacing.begin(), spacing.end(), ',', ' ');
    EXPECT_EQ(row[4], spacing);
    if (!volume.credit.empty()) {
      EXPECT_EQ(row[5], volume.credit);
    }
    EXPECT_EQ(findVolume(volume.name), &volume);
  }
  EXPECT_EQ(findVolume("dns")->bytes(), uint64_t{10240} * 7680 * 1536 * 8);
  EXPECT_EQ(findVolume("bonsai")->address(),
            "https://klacansky.com/open-scivis-datasets/bonsai/bonsai_256x256x256_uint8.raw");
}

}  // namespace
}  // namespace sluice
