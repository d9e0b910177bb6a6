#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <atomic>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <random>
#include <set>
#include <thread>

#include "io/fetch_volume.h"
#include "io/open_volume.h"
#include "io/stores/download.h"
#include "io/stores/folder_store.h"
#include "io/stores/sha256.h"
#include "src/base/files/descriptor.h"
#include "tests/io/web/web_server.h"
#include "tests/support/run_command.h"

namespace sluice {
namespace {

namespace fs = std::filesystem;

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::string sha256Of(std::string_view text) {
  Sha256 sha;
  // The pieces have many lengths.
  for (size_t at = 0, bytes = 1; at < text.size(); at += bytes, bytes = bytes * 2 % 211 + 1)
    sha.add(std::as_bytes(std::span(text.substr(at, bytes))));
  return sha.finish();
}

// The examples of the standard, and the lengths around the end of a block.
TEST(Sha256, givesTheDigestsOfTheStandard) {
  EXPECT_EQ(sha256Of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256Of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256Of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256Of(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  const TempFolder folder;
  for (const size_t bytes : {55, 56, 63, 64, 65, 119, 120, 128}) {
    const std::string text(bytes, 'x');
    std::ofstream(folder / "f") << text;
    const std::string said = runCommand("sha256sum " + (folder / "f").string()).output;
    EXPECT_EQ(sha256Of(text), said.substr(0, 64)) << bytes;
  }
}

// A file of random bytes behind a server.
class Fetch : public testing::Test {
 protected:
  static constexpr uint64_t kBytes = 1000003;

  Fetch() {
    std::mt19937 random(7);
    for (uint64_t i = 0; i < kBytes; ++i) content_ += static_cast<char>(random());
    fs::create_directories(served_ / "data");
    std::ofstream(served_ / "data/head.raw", std::ios::binary) << content_;
  }

  FetchOptions options() const {
    FetchOptions options;
    options.download.piece_bytes = 30000;
    return options;
  }
  FetchedVolume fetch(const WebServer& server, const FetchOptions& with) const {
    ProgressMeter nobody;
    return fetchVolume(server.address() + "/data/head.raw", target_, with, nobody);
  }
  // Only the file is there, with its bytes.
  void expectWhole() const {
    EXPECT_TRUE(readFile(target_) == content_);
    EXPECT_FALSE(fs::exists(target_.string() + ".part"));
    EXPECT_FALSE(fs::exists(target_.string() + ".part-of"));
  }
  // Puts the first bytes of the object in the place where an earlier run left them.
  void leavePart(const WebServer& server, uint64_t bytes, const std::string& stamp) const {
    std::ofstream(target_.string() + ".part", std::ios::binary) << content_.substr(0, bytes);
    std::ofstream(target_.string() + ".part-of") << server.address() << "/data/head.raw\n"
                                                 << content_.size() << "\n"
                                                 << stamp << "\n";
  }
  // The ETag of the server.
  std::string stamp() const {
    struct stat about {};
    stat((served_ / "data/head.raw").c_str(), &about);
    return "\"first-" + std::to_string(content_.size()) + "-" +
           std::to_string(about.st_mtim.tv_sec * 1000000000 + about.st_mtim.tv_nsec) + "\"";
  }

  const TempFolder served_, here_;
  const fs::path target_ = here_ / "head.raw";
  std::string content_;
};

TEST_F(Fetch, copiesAFileAndAsksForNothingTwice) {
  const WebServer server(served_.path());
  FetchOptions with = options();
  with.expected = {kBytes, sha256Of(content_)};
  const FetchedVolume fetched = fetch(server, with);
  expectWhole();
  EXPECT_EQ(fetched.object.bytes, kBytes);
  EXPECT_EQ(fetched.object.resumed_bytes, 0U);
  EXPECT_EQ(fetched.object.sha256, sha256Of(content_));
  std::set<std::string> ranges;
  uint64_t bytes = 0;
  for (const WebRequest& r : server.requests()) {
    if (r.path != "data/head.raw") continue;
    EXPECT_TRUE(ranges.insert(r.range).second) << r.range;
    bytes += r.bytes;
  }
  EXPECT_EQ(bytes, kBytes);
}

TEST_F(Fetch, faultsThatPassChangeNoByte) {
  for (const char* fault : {"drop", "silent", "delay", "busy", "broken", "long"}) {
    SCOPED_TRACE(fault);
    const WebServer server(served_.path(), fault);
    fs::remove(target_);
    fetch(server, options());
    expectWhole();
  }
}

TEST_F(Fetch, faultsThatDoNotPassAreOneLineAndNoFile) {
  const std::map<std::string, std::string> lines = {{"changed", "changed while"},
                                                    {"gzip", "Content-Encoding"}};
  for (const auto& [fault, line] : lines) {
    SCOPED_TRACE(fault);
    const TempFolder folder;
    std::string large = content_ + content_;
    fs::create_directories(folder / "data");
    std::ofstream(folder / "data/head.raw", std::ios::binary) << large;
    const WebServer server(folder.path(), fault);
    EXPECT_THAT(errorOf([&] { fetch(server, options()); }),
                AllOf(StartsWith(server.address() + "/data/head.raw"), HasSubstr(line),
                      Not(HasSubstr("\n"))));
    EXPECT_FALSE(fs::exists(target_));
    fs::remove(target_.string() + ".part");
  }
}

// As Python's http.server sends it.
TEST_F(Fetch, copiesInOneGoWhatDoesNotComeInParts) {
  while (content_.size() < 4 * kBytes) content_ += content_;
  std::ofstream(served_ / "data/head.raw", std::ios::binary) << content_;
  const WebServer server(served_.path(), "whole");
  const std::string part = target_.string() + ".part";
  FetchOptions with = options();
  with.expected = {content_.size(), sha256Of(content_)};
  uint64_t most = 0;
  const auto fetchWatched = [&](const ProgressWatch& watch) {
    ProgressMeter meter(watch);
    return fetchVolume(server.address() + "/data/head.raw", target_, with, meter);
  };
  // A run that ends early leaves nothing that a later one would take for the beginning of the file.
  EXPECT_THAT(errorOf([&] {
                fetchWatched([&](uint64_t done, uint64_t) {
                  most = std::max(most, done);
                  if (done > kBytes) fail("enough");
                });
              }),
              HasSubstr("enough"));
  EXPECT_GT(most, kBytes);
  EXPECT_LT(most, content_.size());
  EXPECT_FALSE(fs::exists(target_) || fs::exists(part) || fs::exists(part + "-of"));
  const FetchedVolume fetched = fetchWatched([&](uint64_t done, uint64_t) {
    EXPECT_TRUE(done == content_.size() || readFile(part + "-of").ends_with("comes whole\n"));
  });
  expectWhole();
  EXPECT_EQ(fetched.object.sha256, sha256Of(content_));
  // The server sent parts when an earlier run began.
  fs::remove(target_);
  leavePart(server, 3 * kBytes, stamp());
  EXPECT_EQ(fetchWatched({}).object.resumed_bytes, 0U);
  expectWhole();
}

TEST_F(Fetch, anAnswerThatBreaksOffComesAgainFromItsStart) {
  while (content_.size() < 4 * kBytes) content_ += content_;
  std::ofstream(served_ / "data/head.raw", std::ios::binary) << content_;
  FetchOptions with = options();
  with.download.piece_bytes = 3 * kBytes;
  fetch(WebServer(served_.path(), "whole-drop"), with);
  expectWhole();
  fs::remove(target_);
  EXPECT_THAT(errorOf([&] { fetch(WebServer(served_.path(), "whole-cut"), with); }),
              AllOf(HasSubstr("2000006 of 4000012 bytes came"), HasSubstr("begins anew"),
                    Not(HasSubstr("\n"))));
  EXPECT_TRUE(fs::is_empty(here_.path()));
}

TEST_F(Fetch, writesOverNothingThatNoFetchBegan) {
  const WebServer server(served_.path());
  const std::string own = target_.string() + ".part";
  std::ofstream(own) << "notes";
  EXPECT_EQ(errorOf([&] { fetch(server, options()); }),
            own + ": expected nothing of this name, or what a fetch began; move or remove it");
  EXPECT_EQ(readFile(own), "notes");
  EXPECT_FALSE(fs::exists(target_));
}

// Servers answer 416 to a request for the first part of an empty file.
TEST_F(Fetch, copiesAnEmptyFile) {
  content_.clear();
  std::ofstream(served_ / "data/head.raw", std::ios::trunc).close();
  for (const char* fault : {"", "whole"}) {
    SCOPED_TRACE(fault);
    const WebServer server(served_.path(), fault);
    fs::remove(target_);
    const FetchedVolume fetched = fetch(server, options());
    EXPECT_EQ(fetched.object.bytes, 0U);
    EXPECT_EQ(fetched.object.sha256, sha256Of(""));
    ASSERT_TRUE(fs::exists(target_));
    expectWhole();
  }
}

TEST_F(Fetch, leavesNoFileIfNothingCame) {
  for (const char* fault : {"gzip", "loop", "down"}) {
    SCOPED_TRACE(fault);
    const WebServer server(served_.path(), fault);
    EXPECT_NE(errorOf([&] { fetch(server, options()); }), "");
    EXPECT_TRUE(fs::is_empty(here_.path()));
  }
}

// An object in memory.
class OneObject : public ChunkStore {
 public:
  explicit OneObject(std::string bytes) : bytes_(std::move(bytes)) {}
  std::string wholeKey(const std::string& key) const override { return key; }
  std::string nameOf(const std::string& key) const override { return key; }
  bool has(const std::string& /*key*/) override { return true; }
  bool read(const std::string& /*key*/, const PieceBytes& wanted, const Room& room) override {
    const std::span<std::byte> out = room({bytes_.size(), false});
    std::memcpy(out.data(), bytes_.data() + wanted.offset, out.size());
    return true;
  }
  std::string stampOf(const std::string& /*key*/) override { return "stamp"; }
  bool canList() const override { return false; }
  void list(const std::string& /*folder*/,
            const std::function<void(const Entry&)>& /*take*/) override {}

 private:
  const std::string bytes_;
};

// One that is late may open FILE.part when it is about to become FILE. It was cut then.
TEST_F(Fetch, severalAtOnceNeverChangeAWholeFile) {
  const StorePlace object{std::make_shared<OneObject>(content_.substr(0, 5000)), "object"};
  std::atomic<bool> is_over{false}, was_cut{false};
  std::atomic<int> done{0};
  std::map<std::string, int> errors;
  std::mutex mutex;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      while (!is_over) {
        ProgressMeter nobody;
        try {
          download(object, target_, {}, {.has_checksum = false}, nobody);
          ++done;
        } catch (const Error& error) {
          const std::lock_guard lock(mutex);
          ++errors[error.what()];
        }
      }
    });
  for (int i = 0; i < 100000 && (done < 500 || i < 1000); ++i) {
    std::error_code missing;
    const auto bytes = fs::file_size(target_, missing);
    was_cut = was_cut || (!missing && bytes != 5000);
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  is_over = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_FALSE(was_cut);
  EXPECT_GE(done, 500);
  errors.erase(target_.string() + ": another process is fetching it");
  EXPECT_TRUE(errors.empty()) << errors.begin()->first;
}

TEST_F(Fetch, anotherSizeOrChecksumThanExpectedIsOneLineAndNoFile) {
  const WebServer server(served_.path());
  FetchOptions wrong = options();
  wrong.expected.bytes = kBytes + 1;
  EXPECT_THAT(errorOf([&] { fetch(server, wrong); }),
              AllOf(HasSubstr("expected 1000004 bytes, found 1000003"), Not(HasSubstr("\n"))));
  wrong.expected = {kBytes, std::string(64, '0')};
  EXPECT_THAT(errorOf([&] { fetch(server, wrong); }),
              AllOf(HasSubstr("expected the SHA-256 0000"), HasSubstr(sha256Of(content_)),
                    Not(HasSubstr("\n"))));
  EXPECT_TRUE(fs::is_empty(here_.path()));
}

TEST_F(Fetch, goesOnWhereItStopped) {
  const WebServer server(served_.path());
  for (const uint64_t there : {uint64_t{1}, uint64_t{123456}, kBytes - 1, kBytes}) {
    SCOPED_TRACE(there);
    const size_t before = server.requests().size();
    leavePart(server, there, stamp());
    FetchOptions with = options();
    with.expected.sha256 = sha256Of(content_);
    EXPECT_EQ(fetch(server, with).object.resumed_bytes, there);
    expectWhole();
    uint64_t bytes = 0;
    const std::vector<WebRequest> all = server.requests();
    for (size_t i = before; i < all.size(); ++i)
      if (all[i].path == "data/head.raw" && all[i].status == 206) bytes += all[i].bytes;
    EXPECT_EQ(bytes, kBytes - there);
  }
}

TEST_F(Fetch, beginsAnewIfTheObjectHasChanged) {
  const WebServer server(served_.path());
  leavePart(server, 5000, "\"another\"");
  std::ofstream(target_.string() + ".part", std::ios::binary) << std::string(5000, 'x');
  EXPECT_EQ(fetch(server, options()).object.resumed_bytes, 0U);
  expectWhole();
}

TEST_F(Fetch, anObjectThatIsNotThereIsOneLine) {
  const WebServer server(served_.path());
  ProgressMeter nobody;
  EXPECT_THAT(errorOf([&] {
                fetchVolume(server.address() + "/data/none.raw", target_, options(), nobody);
              }),
              AllOf(HasSubstr("/data/none.raw: the server has no such file; check the address"),
                    Not(HasSubstr("\n"))));
  EXPECT_TRUE(fs::is_empty(here_.path()));
}

}  // namespace
}  // namespace sluice
