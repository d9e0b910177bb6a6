// A disk of so many bytes a second (SLUICE_SLOW_BYTES_PER_SECOND), for a program that is started
// with this library in LD_PRELOAD: reads of files whose names hold SLUICE_SLOW_FILE take as long as
// such a disk would. Listing a folder whose name holds SLUICE_SLOW_FOLDER takes a second an entry.
#include <dirent.h>
#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>

namespace {

using Clock = std::chrono::steady_clock;

bool isSlow(int file, const char* variable = "SLUICE_SLOW_FILE") {
  const char* const name = std::getenv(variable);
  if (name == nullptr) return false;
  char path[4096];
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  const ssize_t length = ::readlink(link.c_str(), path, sizeof path - 1);
  if (length <= 0) return false;
  path[length] = '\0';
  return std::strstr(path, name) != nullptr;
}

// Waits until the disk would have given these bytes, one request behind the other.
void wait(ssize_t bytes) {
  static std::mutex mutex;
  static Clock::time_point free_at;
  const char* const said = std::getenv("SLUICE_SLOW_BYTES_PER_SECOND");
  const double rate = said != nullptr ? std::strtod(said, nullptr) : 50e6;
  Clock::time_point done;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    free_at = std::max(free_at, Clock::now()) +
              std::chrono::duration_cast<Clock::duration>(
                  std::chrono::duration<double>(static_cast<double>(bytes) / rate));
    done = free_at;
  }
  std::this_thread::sleep_until(done);
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

ssize_t slowed(int file, ssize_t bytes) {
  if (bytes > 0 && isSlow(file)) wait(bytes);
  return bytes;
}

}  // namespace

extern "C" ssize_t pread(int file, void* to, size_t bytes, off_t at) {
  static auto* const real = next<ssize_t(int, void*, size_t, off_t)>("pread");
  return slowed(file, real(file, to, bytes, at));
}
extern "C" ssize_t pread64(int file, void* to, size_t bytes, off64_t at) {
  static auto* const real = next<ssize_t(int, void*, size_t, off64_t)>("pread64");
  return slowed(file, real(file, to, bytes, at));
}

extern "C" dirent* readdir(DIR* folder) {
  static auto* const real = next<dirent*(DIR*)>("readdir");
  if (isSlow(dirfd(folder), "SLUICE_SLOW_FOLDER"))
    std::this_thread::sleep_for(std::chrono::seconds(1));
  return real(folder);
}
extern "C" dirent64* readdir64(DIR* folder) {
  static auto* const real = next<dirent64*(DIR*)>("readdir64");
  if (isSlow(dirfd(folder), "SLUICE_SLOW_FOLDER"))
    std::this_thread::sleep_for(std::chrono::seconds(1));
  return real(folder);
}
