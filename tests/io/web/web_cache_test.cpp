#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

#include "io/open_volume.h"
#include "io/web/piece_cache.h"
#include "tests/io/python_volumes.h"
#include "tests/io/web/web_server.h"
#include "tests/io/zarr/zarr_case.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr uint64_t kPlenty = 64 << 20;

std::vector<fs::path> piecesIn(const fs::path& cache) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(cache / "pieces")) files.push_back(entry.path());
  return files;
}

// At one moment, since nothing changes under the lock. Rounded up to blocks, as piece_cache.h says.
uint64_t bytesIn(const fs::path& cache) {
  const Descriptor lock(open((cache / "usage").c_str(), O_RDONLY));
  flock(lock.get(), LOCK_EX);
  uint64_t bytes = 0;
  for (const fs::path& file : piecesIn(cache)) {
    struct stat about {};
    if (stat(file.c_str(), &about) == 0)
      bytes += (static_cast<uint64_t>(about.st_size) + 4095) / 4096 * 4096;
  }
  return bytes;
}

struct CacheCase : ZarrCase {
  static constexpr const char* kScript = "make_zarr3.py";
  static constexpr const char* kModules = "numpy, numcodecs";
};

class WebCacheVolume : public PythonVolumesTest<CacheCase> {
 protected:
  std::string voxelsFrom(const WebServer& server, const std::string& name,
                         uint64_t budget = kPlenty) const {
    OpenOptions options;
    options.web.cache = {cache_ / "web", budget};
    return allSteps(*openVolume(server.address() + "/" + name, options));
  }
  const TempFolder cache_;
};

// The answers' statuses to requests for chunks from number `first` on.
std::vector<int> answersToChunks(const WebServer& server, size_t first) {
  std::vector<int> all;
  const std::vector<WebRequest> requests = server.requests();
  for (size_t i = first; i < requests.size(); ++i)
    if (requests[i].path.find("/c/") != std::string::npos) all.push_back(requests[i].status);
  return all;
}

TEST_F(WebCacheVolume, hasItsPiecesTheNextTime) {
  const WebServer server(folder_);
  for (const char* name : {"one_shard", "keys_v2_slash", "sharded_start"}) {
    if (!fs::exists(pathOf(name))) continue;
    SCOPED_TRACE(name);
    ASSERT_TRUE(voxelsFrom(server, name) == voxelsOf(name));
    const size_t before = server.requests().size();
    EXPECT_TRUE(voxelsFrom(server, name) == voxelsOf(name));
    for (const int status : answersToChunks(server, before)) EXPECT_EQ(status, 304);
  }
}

TEST_F(WebCacheVolume, readsAnewWhatWasWrittenMeanwhile) {
  const TempFolder copy;
  fs::copy(pathOf("one_shard"), copy / "v", fs::copy_options::recursive);
  const WebServer server(copy.path());
  ASSERT_TRUE(voxelsFrom(server, "v") == voxelsOf("one_shard"));
  fs::last_write_time(copy / "v/c/0/0/0", fs::file_time_type::clock::now());
  const size_t before = server.requests().size();
  EXPECT_TRUE(voxelsFrom(server, "v") == voxelsOf("one_shard"));
  const std::vector<int> answers = answersToChunks(server, before);
  EXPECT_FALSE(answers.empty());
  for (const int status : answers) EXPECT_EQ(status, 206);
}

TEST_F(WebCacheVolume, damagedPiecesAreReadAnew) {
  const WebServer server(folder_);
  ASSERT_TRUE(voxelsFrom(server, "one_shard") == voxelsOf("one_shard"));
  const auto damages = std::vector<std::function<void(const fs::path&)>>{
      [](const fs::path& file) { fs::resize_file(file, fs::file_size(file) - 1); },
      [](const fs::path& file) { fs::resize_file(file, 20); },
      [](const fs::path& file) { std::ofstream(file) << "no piece of sluice's, but text"; },
      [](const fs::path& file) {
        std::string bytes = readFile(file);
        bytes.back() = static_cast<char>(bytes.back() ^ 1);
        std::ofstream(file) << bytes;
      }};
  for (size_t i = 0; i < damages.size(); ++i) {
    SCOPED_TRACE(i);
    const std::vector<fs::path> pieces = piecesIn(cache_ / "web");
    ASSERT_FALSE(pieces.empty());
    for (const fs::path& file : pieces) damages[i](file);
    EXPECT_TRUE(voxelsFrom(server, "one_shard") == voxelsOf("one_shard"));
  }
}

TEST_F(WebCacheVolume, keepsWithinItsLimitAndTellsNoSecret) {
  const WebServer server(folder_);
  for (const uint64_t limit : {uint64_t{1}, uint64_t{20000}, uint64_t{100000}}) {
    SCOPED_TRACE(limit);
    for (const CacheCase& c : cases_) {
      if (c.channel >= 0) continue;
      OpenOptions options;
      options.web.cache = {cache_ / "web", limit};
      const std::string host = server.address().substr(7);
      const auto source =
          openVolume("http://me:secret@" + host + "/" + c.name + "?token=hidden", options);
      EXPECT_TRUE(allSteps(*source) == voxelsOf(c.name)) << c.name;
      EXPECT_LE(bytesIn(cache_ / "web"), limit);
    }
  }
  for (const fs::path& file : piecesIn(cache_ / "web"))
    EXPECT_THAT(readFile(file), AllOf(Not(HasSubstr("secret")), Not(HasSubstr("hidden"))));
}

TEST_F(WebCacheVolume, aFolderThatCannotBeWrittenIsOneLine) {
  const WebServer server(folder_);
  std::ofstream(cache_ / "web") << "a file";
  EXPECT_THAT(errorOf([&] { voxelsFrom(server, "one_shard"); }),
              AllOf(HasSubstr("--cache-dir"), Not(HasSubstr("\n"))));
}

std::vector<std::byte> contentOf(int number) {
  return std::vector<std::byte>(static_cast<size_t>(3000 + 997 * number % 20000),
                                static_cast<std::byte>(number));
}

// Keeps and finds pieces until it is killed; exits with 1 on a wrong one.
[[noreturn]] void useCache(const fs::path& folder, uint64_t limit, int seed) {
  PieceCache cache(folder, limit);
  std::mt19937 random(static_cast<unsigned>(seed));
  for (;;) {
    const int number = static_cast<int>(random() % 60);
    const std::string name = "piece " + std::to_string(number);
    if (const auto found = cache.find(name)) {
      std::vector<std::byte> bytes(found->bytes());
      if (!found->read(bytes) || bytes != contentOf(number)) _exit(1);
    } else {
      cache.keep(name, "\"stamp\"", 7, contentOf(number));
    }
  }
}

TEST(PieceCache, isSharedByProcessesThatAreKilled) {
  const TempFolder folder;
  constexpr uint64_t kLimit = 200000;
  for (int round = 0; round < 12; ++round) {
    std::vector<pid_t> children;
    for (int i = 0; i < 3; ++i) {
      const pid_t child = fork();
      if (child == 0) useCache(folder / "web", kLimit, round * 10 + i);
      children.push_back(child);
    }
    for (int i = 0; i < 10; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (!fs::exists(folder / "web/pieces")) continue;
      EXPECT_LE(bytesIn(folder / "web"), kLimit);
    }
    for (const pid_t child : children) {
      kill(child, SIGKILL);
      int status = 0;
      waitpid(child, &status, 0);
      EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
    }
  }
  // What the killed were writing goes when room is made, and the rest is whole.
  PieceCache cache(folder / "web", kLimit);
  for (int number = 0; number < 60; ++number)
    cache.keep("other " + std::to_string(number), "\"s\"", 7, contentOf(number));
  for (const fs::path& file : piecesIn(folder / "web"))
    EXPECT_FALSE(file.filename().string().starts_with("writing-")) << file;
  EXPECT_LE(bytesIn(folder / "web"), kLimit);
  EXPECT_TRUE(cache.find("other 59"));
}

TEST(PieceCache, forgetsWhatWasNotUsedForLongest) {
  const TempFolder folder;
  PieceCache cache(folder / "web", 10 * 8192);
  const std::vector<std::byte> bytes(5000);
  for (int i = 0; i < 10; ++i) cache.keep(std::to_string(i), "\"s\"", 1, bytes);
  // File systems tell times of use some milliseconds apart.
  for (const int i : {1, 2, 3, 4, 5, 6, 7, 8, 9, 0}) {
    std::this_thread::sleep_for(std::chrono::milliseconds(15));
    EXPECT_TRUE(cache.find(std::to_string(i))) << i;
  }
  cache.keep("10", "\"s\"", 1, bytes);
  EXPECT_TRUE(cache.find("0"));
  EXPECT_FALSE(cache.find("1"));
  EXPECT_TRUE(cache.find("10"));
}

// The first process of each container has the same number.
TEST(PieceCache, takesOverFromADeadProcessOfItsNumber) {
  const TempFolder folder;
  PieceCache cache(folder / "web", kPlenty);
  const std::vector<std::byte> bytes(5000);
  ASSERT_EQ(cache.keep("one", "\"s\"", 1, bytes), std::nullopt);
  const fs::path piece = piecesIn(folder / "web").front();
  const fs::path left =
      piece.parent_path() / fmt::format("writing-{}-{}", getpid(), piece.filename().string());
  fs::rename(piece, left);
  EXPECT_EQ(cache.keep("one", "\"s\"", 1, bytes), std::nullopt);
  EXPECT_TRUE(cache.find("one"));
  EXPECT_FALSE(fs::exists(left));
}

TEST(PieceCache, saysWhyAPieceIsNotKept) {
  const TempFolder folder;
  PieceCache cache(folder / "web", kPlenty);
  fs::remove(folder / "web/pieces");
  EXPECT_EQ(cache.keep("one", "\"s\"", 1, std::vector<std::byte>(5000)),
            (folder / "web").string() + ": No such file or directory");
  // No room under the limit is no fault.
  PieceCache small(folder / "small", 4096);
  EXPECT_EQ(small.keep("one", "\"s\"", 1, std::vector<std::byte>(5000)), std::nullopt);
  EXPECT_TRUE(piecesIn(folder / "small").empty());
}

}  // namespace
}  // namespace sluice
