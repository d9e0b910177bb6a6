// Copies of stores from a web server: whole, begun by an earlier run, and beside what others left.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>

#include <fstream>
#include <map>

#include "io/fetch_volume.h"
#include "io/open_volume.h"
#include "src/base/files/descriptor.h"
#include "tests/io/python_volumes.h"
#include "tests/io/web/web_server.h"
#include "tests/io/zarr/zarr_case.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::StartsWith;

struct FetchCase : ZarrCase {
  static constexpr const char* kScript = "make_zarr3.py";
  static constexpr const char* kModules = "numpy, numcodecs";
};

class FetchStore : public PythonVolumesTest<FetchCase> {};

// Every store of the script: what is fetched has the voxels of what lies at the server, and of the
// files that readers need each is there.
TEST_F(FetchStore, hasTheVoxelsAndAsksForNothingTwice) {
  const TempFolder here;
  const WebServer server(folder_);
  for (const FetchCase& c : cases_) {
    SCOPED_TRACE(c.name);
    const fs::path target = here.path() / fs::path(c.name).filename();
    fs::remove_all(target);
    ProgressMeter nobody;
    const FetchedVolume fetched = fetchVolume(server.address() + "/" + c.name, target, {}, nobody);
    EXPECT_TRUE(fetched.is_store);
    EXPECT_FALSE(fs::exists(target.string() + ".part"));
    OpenOptions options;
    options.channel = c.options().channel;
    EXPECT_TRUE(allSteps(*openVolume(target.string(), options)) == voxelsOf(c.name));
    for (const auto& entry : fs::recursive_directory_iterator(target))
      if (entry.is_regular_file()) {
        EXPECT_EQ(readFile(entry.path()),
                  readFile(fs::path(folder_) / c.name / fs::relative(entry.path(), target)));
      }
  }
  std::map<std::string, int> chunks;
  for (const WebRequest& r : server.requests())
    if (r.path.find("/c/") != std::string::npos) ++chunks[r.path + " " + r.range];
  EXPECT_FALSE(chunks.empty());
}

// A store that was begun: all but one of its files are there.
class BegunStore : public FetchStore {
 protected:
  void begin(const std::string& address) const {
    // The last step fails: there is something of the name.
    fs::create_directories(target_ / "other");
    ProgressMeter nobody;
    EXPECT_THAT(errorOf([&] { fetchVolume(address, target_, {}, nobody); }),
                HasSubstr("cannot be written"));
    fs::remove_all(target_);
    ASSERT_TRUE(fs::remove(target_.string() + ".part/c/0/0/0"));
  }
  // Returns the bytes of the files that were there.
  uint64_t goOn(const std::string& address) const {
    ProgressMeter nobody;
    const FetchedVolume fetched = fetchVolume(address, target_, {}, nobody);
    EXPECT_TRUE(fs::is_directory(target_));
    EXPECT_EQ(std::distance(fs::directory_iterator(here_.path()), {}), 1);
    return fetched.object.resumed_bytes;
  }
  const TempFolder here_;
  const fs::path target_ = here_ / "v";
};

TEST_F(BegunStore, goesOnWithTheFilesThatAreMissing) {
  const WebServer server(folder_);
  begin(server.address() + "/one_shard");
  const size_t before = server.requests().size();
  EXPECT_GT(goOn(server.address() + "/one_shard"), 0U);
  EXPECT_TRUE(allSteps(*openVolume(target_.string())) == voxelsOf("one_shard"));
  int chunks = 0;
  const std::vector<WebRequest> all = server.requests();
  for (size_t i = before; i < all.size(); ++i) chunks += all[i].path == "one_shard/c/0/0/0";
  EXPECT_EQ(chunks, 1);
}

// Chunks of two stores would be one volume.
TEST_F(BegunStore, beginsAnewIfItIsAnotherStoreOrHasChanged) {
  const TempFolder served;
  for (const char* name : {"a/v", "b/v"}) {
    fs::create_directories(served / name);
    fs::copy(pathOf("one_shard"), served / name, fs::copy_options::recursive);
  }
  const WebServer server(served.path());
  begin(server.address() + "/a/v");
  EXPECT_EQ(goOn(server.address() + "/b/v"), 0U);
  fs::remove_all(target_);
  begin(server.address() + "/a/v");
  fs::last_write_time(served / "a/v/zarr.json", fs::file_time_type::clock::now());
  EXPECT_EQ(goOn(server.address() + "/a/v"), 0U);
  EXPECT_TRUE(allSteps(*openVolume(target_.string())) == voxelsOf("one_shard"));
}

TEST_F(BegunStore, removesNothingThatNoFetchBegan) {
  const WebServer server(folder_);
  const fs::path own = target_.string() + ".part";
  fs::create_directories(own / "notes");
  ProgressMeter nobody;
  EXPECT_THAT(errorOf([&] { fetchVolume(server.address() + "/one_shard", target_, {}, nobody); }),
              HasSubstr("move or remove it"));
  EXPECT_TRUE(fs::exists(own / "notes"));
  const std::string origin = target_.string() + ".part-of";
  EXPECT_FALSE(fs::exists(origin));
  std::ofstream(origin) << "to do\n";
  EXPECT_THAT(errorOf([&] { fetchVolume(server.address() + "/one_shard", target_, {}, nobody); }),
              StartsWith(origin + ": expected"));
  EXPECT_TRUE(fs::exists(own / "notes"));
  EXPECT_EQ(readFile(origin), "to do\n");
}

TEST_F(BegunStore, isOneProcessesAlone) {
  const WebServer server(folder_);
  begin(server.address() + "/one_shard");
  const Descriptor other(open((target_.string() + ".part-of").c_str(), O_RDWR));
  ASSERT_EQ(flock(other.get(), LOCK_EX | LOCK_NB), 0);
  ProgressMeter nobody;
  EXPECT_EQ(errorOf([&] { fetchVolume(server.address() + "/one_shard", target_, {}, nobody); }),
            target_.string() + ": another process is fetching it");
  EXPECT_FALSE(fs::exists(target_));
}

}  // namespace
}  // namespace sluice
