#include "cli/progress.h"

#include <unistd.h>

#include <cstdio>

namespace vol::cli {

Progress::Progress(std::string label, std::int64_t total, bool enabled)
    : label_(std::move(label)), total_(total), enabled_(enabled && ::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (drawn_) std::fprintf(stderr, "\r\033[K");
}

void Progress::advance(std::int64_t n) {
  const std::int64_t done = done_.fetch_add(n) + n;
  if (!enabled_) return;
  const auto now = static_cast<std::int64_t>(timer_.seconds() * 1000);
  std::int64_t due = next_draw_.load();
  if (now >= due && next_draw_.compare_exchange_strong(due, now + 100)) draw(done);
}

void Progress::draw(std::int64_t done) {
  constexpr int kWidth = 40;
  const int filled = total_ > 0 ? static_cast<int>(kWidth * done / total_) : 0;
  drawn_ = true;
  std::fprintf(stderr, "\r%s [%.*s%*s] %3d%%", label_.c_str(), filled, "########################################",
               kWidth - filled, "", total_ > 0 ? static_cast<int>(100 * done / total_) : 0);
  std::fflush(stderr);
}

}  // namespace vol::cli
