#pragma once
#include <memory>
#include <string>

namespace vol::cli {

/// The line on standard error that says what a long run is at: the phase, the seconds so far, and a bar of
/// how far its parallel loop has come. Only on a terminal, only when the run lasts over a second, never with
/// --quiet. A thread of its own looks at base/parallel.h's loop_progress() ten times a second, so the work
/// itself knows nothing of it. Between phases the line is empty, for what the tool has to say.
class Progress {
 public:
  explicit Progress(std::string tool);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Names what runs from now on; "" is nothing: the line is cleared and stays so. Returns what ran until
  /// now.
  std::string phase(std::string name) noexcept;

 private:
  struct Display;
  std::unique_ptr<Display> display_;  // null where nothing is to be shown
};

/// Clears the line if there is one. Async-signal-safe; called by the signal handler.
void clear_progress() noexcept;

}  // namespace vol::cli
