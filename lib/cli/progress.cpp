#include "cli/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>

#include "base/parallel.h"
#include "base/timer.h"

namespace vol::cli {
namespace {

constexpr std::chrono::milliseconds kPatience{1000};  // shorter runs show nothing
constexpr std::chrono::milliseconds kPeriod{100};
constexpr int kBarColumns = 40;
constexpr char kClear[] = "\r\033[K";

std::atomic<bool> is_drawn{false};

std::size_t terminal_columns() {
  struct winsize size {};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

void draw(const std::string& tool, const std::string& phase, double seconds) {
  const LoopProgress loop = loop_progress();
  std::string line = tool + ": " + phase + " ";
  if (loop.total > 1) {
    const double share = static_cast<double>(loop.done) / static_cast<double>(loop.total);
    const auto filled = static_cast<std::size_t>(kBarColumns * share);
    line += "[" + std::string(filled, '#') + std::string(kBarColumns - filled, ' ') + "] " +
            std::to_string(static_cast<int>(100 * share)) + "%, ";
  }
  line += std::to_string(static_cast<int>(seconds)) + " s";
  line.resize(std::min(line.size(), terminal_columns() - 1));  // a line that wraps could not be cleared
  is_drawn.store(true);
  std::fprintf(stderr, "%s%s", kClear, line.c_str());
  std::fflush(stderr);
}

}  // namespace

void clear_progress() noexcept {
  if (is_drawn.exchange(false)) (void)!::write(STDERR_FILENO, kClear, sizeof kClear - 1);
}

struct Progress::Display {
  std::string tool;
  std::string phase;
  bool is_over = false;
  Timer timer;
  std::mutex mutex;
  std::condition_variable end;
  std::thread thread;

  explicit Display(std::string name) : tool(std::move(name)), thread([this] { watch(); }) {}
  ~Display() {
    {
      const std::lock_guard lock(mutex);
      is_over = true;
      clear_progress();
    }
    end.notify_one();
    thread.join();
  }
  void watch() {
    std::unique_lock lock(mutex);
    const auto over = [this] { return is_over; };
    for (bool done = end.wait_for(lock, kPatience, over); !done; done = end.wait_for(lock, kPeriod, over)) {
      if (!phase.empty()) draw(tool, phase, timer.seconds());
    }
  }
};

Progress::Progress(std::string tool) {
  if (::isatty(STDERR_FILENO) == 1) display_ = std::make_unique<Display>(std::move(tool));
}

Progress::~Progress() = default;

std::string Progress::phase(std::string name) noexcept {
  if (!display_) return {};
  const std::lock_guard lock(display_->mutex);
  if (name.empty()) clear_progress();
  display_->phase.swap(name);
  return name;
}

}  // namespace vol::cli
