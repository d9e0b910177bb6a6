#include "src/base/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "src/base/bytes.h"

namespace sluice {
namespace {
constexpr double kFirstDrawSeconds = 0.5;
constexpr double kRedrawSeconds = 0.2;
}  // namespace

Progress::Progress(std::string label, uint64_t total_bytes)
    : label_(std::move(label)), visible_(isatty(STDERR_FILENO) == 1), total_bytes_(total_bytes) {}

Progress::~Progress() {
  if (drawn_at_s_ > 0) std::fputs("\r\033[K", stderr);
}

void Progress::add(uint64_t bytes) {
  const uint64_t done = done_bytes_.fetch_add(bytes) + bytes;
  if (visible_) draw(done);
}

void Progress::draw(uint64_t done) {
  const double now_s = watch_.seconds();
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock || now_s < kFirstDrawSeconds || now_s - drawn_at_s_ < kRedrawSeconds) return;
  drawn_at_s_ = now_s;
  const uint64_t total = total_bytes_;
  const double rate = static_cast<double>(done) / now_s;
  const double left_s = rate > 0 ? static_cast<double>(total - std::min(done, total)) / rate : 0;
  const double share = total == 0 ? 1 : static_cast<double>(done) / static_cast<double>(total);
  fmt::print(stderr, "\r\033[K{} {:.0f} % of {}, {}/s, {:.0f} s left", label_,
             100 * std::min(share, 1.0), formatBytes(total),
             formatBytes(static_cast<uint64_t>(rate)), left_s);
  std::fflush(stderr);
}

}  // namespace sluice
