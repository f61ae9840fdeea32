// Progress of a run; see progress.h.
#include <tools/command/progress.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace scree::command {
namespace {

constexpr int kBarWidth = 40;                            // characters
constexpr auto kRedraw = std::chrono::milliseconds(50);  // more often is invisible, and costs time

double seconds_between(std::chrono::steady_clock::time_point from, std::chrono::steady_clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

}  // namespace

Progress::Progress(std::string title, int steps, bool enabled)
    : title_(std::move(title)), steps_(steps), enabled_(enabled), terminal_(isatty(STDERR_FILENO) == 1) {
  start_ = std::chrono::steady_clock::now();
  drawn_ = start_;
  if (enabled_ && terminal_) draw_bar(0);
}

void Progress::show(int done) {
  if (!enabled_) return;
  const auto now = std::chrono::steady_clock::now();
  if (terminal_) {
    if (now - drawn_ < kRedraw && done < steps_) return;
    drawn_ = now;
    draw_bar(done);
    return;
  }
  const int tenths = static_cast<int>(10LL * done / steps_);
  if (tenths == tenths_) return;
  tenths_ = tenths;
  std::fprintf(stderr, "%s: %3d %%, step %d of %d, %.1f s\n", title_.c_str(), 10 * tenths, done, steps_,
               seconds_between(start_, now));
}

void Progress::finish() {
  if (enabled_ && terminal_) std::fprintf(stderr, "\r\033[K");
}

void Progress::draw_bar(int done) {
  const int filled = static_cast<int>(static_cast<long long>(kBarWidth) * done / steps_);
  const double elapsed = seconds_between(start_, std::chrono::steady_clock::now());
  const double left = done > 0 ? elapsed * (steps_ - done) / done : 0.0;
  const std::string bar = std::string(static_cast<std::size_t>(filled), '#') +
                          std::string(static_cast<std::size_t>(kBarWidth - filled), '.');
  std::fprintf(stderr, "\r%s [%s] %3d %%  step %d of %d  %.0f s left \033[K", title_.c_str(), bar.c_str(),
               static_cast<int>(100LL * done / steps_), done, steps_, left);
  std::fflush(stderr);
}

}  // namespace scree::command
