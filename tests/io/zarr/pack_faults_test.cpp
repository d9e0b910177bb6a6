// Packing on file systems that fail: this program's own flock() and fsync() do so if a test asks.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>

#include "io/zarr/packing/zarr_writer.h"
#include "src/base/error.h"
#include "tests/io/image_test_support.h"
#include "tests/support/function_source.h"

namespace {

std::atomic<bool> g_has_locks = true;
std::atomic<int> g_syncs_left = INT_MAX;

}  // namespace

// As on a network file system without a lock daemon.
extern "C" int flock(int file, int operation) noexcept {
  if (g_has_locks) return static_cast<int>(syscall(SYS_flock, file, operation));
  errno = ENOLCK;
  return -1;
}

// As on a disk that is full once the bytes have to reach it.
extern "C" int fsync(int file) {
  if (g_syncs_left-- > 0) return static_cast<int>(syscall(SYS_fsync, file));
  errno = ENOSPC;
  return -1;
}

namespace sluice {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class PackFaults : public testing::Test {
 protected:
  ~PackFaults() override {
    g_has_locks = true;
    g_syncs_left = INT_MAX;
  }
  // The error of packing; empty if there is none.
  std::string pack(const PackOptions& options = {.chunk_voxels = 16}) {
    VolumeLayout layout;
    layout.dims = {40, 30, 20};
    FunctionSource source(layout,
                          [](int64_t /*t*/, Vec3i at) { return static_cast<double>(at.x + at.y); });
    WorkerPool pool(2);
    ProgressMeter progress;
    try {
      packZarr(source, store_, options, pool, progress);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  const TempFolder folder_;
  const fs::path store_ = folder_ / "v.zarr";
};

TEST_F(PackFaults, leaveNothingOnAFileSystemWithoutLocks) {
  g_has_locks = false;
  EXPECT_THAT(pack(), AllOf(HasSubstr("v.zarr.partial/lock: cannot be locked"),
                            HasSubstr("another file system"), HasSubstr("No locks")));
  EXPECT_TRUE(fs::is_empty(folder_.path()));
  g_has_locks = true;
  EXPECT_EQ(pack(), "");
}

TEST_F(PackFaults, beforeTheLastFileSayHowToGoOn) {
  PackOptions shards{.chunk_voxels = 16};
  shards.shard_voxels = Vec3i{32, 32, 32};
  for (const PackOptions& options : {PackOptions{.chunk_voxels = 16}, shards}) {
    fs::remove_all(store_);
    int failed = 0;
    for (g_syncs_left = 1;; g_syncs_left = ++failed) {
      const std::string error = pack(options);
      if (error.empty()) break;
      ASSERT_LT(failed, 50);
      // The first one only notes what is packed.
      EXPECT_THAT(error,
                  AllOf(HasSubstr("No space left"), HasSubstr("give the same command again")))
          << failed;
    }
    EXPECT_GT(failed, 1);
    g_syncs_left = INT_MAX;
  }
}

}  // namespace
}  // namespace sluice
