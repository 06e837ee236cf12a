#pragma once
#include <atomic>
#include <cstdint>
#include <string>

#include "base/timer.h"

namespace vol::cli {

/// Progress bar on standard error: only on a terminal, only when work lasts over a second, never with --quiet.
/// advance() may be called from any thread.
class Progress {
 public:
  Progress(std::string label, std::int64_t total, bool enabled = true);
  ~Progress();
  void advance(std::int64_t n = 1);

 private:
  void draw(std::int64_t done);
  std::string label_;
  std::int64_t total_;
  bool enabled_;
  bool drawn_ = false;
  std::atomic<std::int64_t> done_{0};
  std::atomic<std::int64_t> next_draw_{1000};  // milliseconds
  Timer timer_;
};

}  // namespace vol::cli
