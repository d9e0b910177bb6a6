#include "tools/command_line/progress_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <utility>

#include "src/base/files/shell_word.h"
#include "src/base/threads/clock.h"
#include "src/base/values/bytes.h"

namespace sluice {
namespace {
// Work that is done sooner shows no line, which would only flicker.
constexpr double kFirstDrawSeconds = 0.5;
constexpr double kRedrawSeconds = 0.2;

// A failure to write is ignored: progress that cannot be shown is lost.
void show(const std::string& text) {
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
}

class Line {
 public:
  Line(const std::string& label, ProgressUnit unit) : label_(shownName(label)), unit_(unit) {}
  ~Line() {
    if (drawn_at_s_ > 0)
      show(fmt::format("\r\033[K{}: {} in {:.1f} s\n", label_,
                       unit_ == ProgressUnit::kShare ? shareText() : textOf(done_),
                       watch_.seconds()));
  }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;

  void tell(uint64_t done, uint64_t total) {
    done_ = done;
    total_ = total;
    const double now_s = watch_.seconds();
    if (now_s < kFirstDrawSeconds || now_s - drawn_at_s_ < kRedrawSeconds) return;
    drawn_at_s_ = now_s;
    const double rate = static_cast<double>(done) / now_s;
    const double left_s = rate > 0 ? static_cast<double>(total - std::min(done, total)) / rate : 0;
    const double share = total == 0 ? 1 : static_cast<double>(done) / static_cast<double>(total);
    std::string amounts;
    if (unit_ == ProgressUnit::kBytes)
      amounts =
          fmt::format(" of {}, {}/s", textOf(total), formatBytes(static_cast<uint64_t>(rate)));
    if (unit_ == ProgressUnit::kPieces)
      amounts = fmt::format(" of {}, {:.2f} s each", textOf(total), rate > 0 ? 1 / rate : 0);
    show(fmt::format("\r\033[K{} {:.0f} %{}, {:.0f} s left", label_, 100 * std::min(share, 1.0),
                     amounts, left_s));
  }

 private:
  std::string shareText() const {
    if (done_ >= total_) return "done";
    return fmt::format("{:.0f} %", 100 * static_cast<double>(done_) / static_cast<double>(total_));
  }
  std::string textOf(uint64_t amount) const {
    return unit_ == ProgressUnit::kBytes ? formatBytes(amount) : fmt::format("{}", amount);
  }

  const std::string label_;
  const ProgressUnit unit_;
  const Stopwatch watch_{};
  uint64_t done_ = 0, total_ = 0;
  double drawn_at_s_ = 0;  // 0: never drawn
};

}  // namespace

ProgressWatch progressLine(const std::string& label, ProgressUnit unit) {
  if (isatty(STDERR_FILENO) != 1) return {};
  auto line = std::make_shared<Line>(label, unit);
  return [line](uint64_t done, uint64_t total) { line->tell(done, total); };
}

}  // namespace sluice
