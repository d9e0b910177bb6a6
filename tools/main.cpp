// sluice: renders volumes larger than memory, from the command line.
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>

#include "tools/command_line/console.h"
#include "tools/program.h"

namespace {

// Slices and steps of a series are files of their own, many of them open at once, and a soft limit
// is only the shell's habit.
void raiseFileLimit() {
  constexpr rlim_t kPlenty = 65536;
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= kPlenty) return;
  limit.rlim_cur = std::min(limit.rlim_max, kPlenty);
  setrlimit(RLIMIT_NOFILE, &limit);
}

// A file that grows beyond `ulimit -f` is a write that fails, as on a full disk, and no signal that
// ends the process with its temporary files left behind.
void failLargeWrites() {
  std::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace

int main(int argc, char** argv) {
  // Blocks and chunks go back to the system when they are freed: --memory bounds the memory that
  // the process takes, not what its allocator keeps. Blosc takes a little more than 128 KiB for
  // each chunk that it packs, which would be mapped anew a thousand times.
  constexpr int kMapFromBytes = 160 << 10;
  mallopt(M_MMAP_THRESHOLD, kMapFromBytes);
  // Except for the total of a frame's small pieces, which the next frame needs again.
  constexpr int kKeptBytes = 8 << 20;
  mallopt(M_TRIM_THRESHOLD, kKeptBytes);
  // An arena a thread takes 64 MiB of addresses, which a driver needs more if they are limited.
  rlimit addresses{};
  if (getrlimit(RLIMIT_AS, &addresses) == 0 && addresses.rlim_cur != RLIM_INFINITY)
    mallopt(M_ARENA_MAX, 1);
  sluice::openStandardStreams();
  raiseFileLimit();
  failLargeWrites();
  return sluice::runProgram({argv + (argc > 0 ? 1 : 0), argv + argc});
}
