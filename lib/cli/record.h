#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "base/timer.h"

namespace vol::cli {

class Progress;

/// The stats record of one run (stats.schema.json): what was asked, what it cost, what is known of its error.
class Record {
 public:
  Record();
  ~Record();
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  /// Runs f and adds its wall time to time_s[phase]. Phases "read" and "write" are the file work; every other
  /// name is a part of "compute".
  template <class F>
  decltype(auto) timed(std::string_view phase, F&& f) {
    const Stopwatch watch(*this, phase);
    return std::forward<F>(f)();
  }
  /// Runs f as often as --repeat says, records every time, and returns the last result: for the compute phase
  /// whose median a sweep takes.
  template <class F>
  auto repeated(std::string_view phase, F&& f) {
    for (int n = 1; n < repeat_; ++n) (void)timed(phase, f);
    return timed(phase, f);
  }

  void count(std::string_view name, std::int64_t value);
  /// A figure of the result: number, string, array or object.
  void result(std::string_view name, const nlohmann::json& value);
  /// What is known of the error: a figure, a bound or an estimate; the name says which.
  void error(std::string_view name, const nlohmann::json& value);
  void seed(std::uint64_t value);
  void device(std::string_view name);
  void input(const std::filesystem::path& path);
  void output(const std::filesystem::path& path);
  /// Adds to the provenance what determines the content but came by a file (a scene, say).
  void resolved(std::string_view name, const nlohmann::json& value);

  /// What every output carries: "precis.tool", "precis.version", "precis.options" (JSON of the resolved options
  /// that determine the content; no paths, dates, hosts, thread counts).
  [[nodiscard]] std::map<std::string, std::string> provenance() const;

  [[nodiscard]] bool quiet() const { return quiet_; }
  [[nodiscard]] bool verbose() const { return verbose_; }
  /// One line on standard error, unless --quiet.
  void say(std::string_view message) const;
  /// `tool: warning: message` on standard error, --quiet or not.
  void warn(std::string_view message) const;

 private:
  friend class Runner;
  /// Times a phase and names it on the progress line while it runs. The place of the time is made at the start:
  /// the end, which may come while an error is on its way, takes no memory.
  class Stopwatch {
   public:
    Stopwatch(Record& record, std::string_view phase);
    ~Stopwatch() noexcept;
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

   private:
    Record& record_;
    std::size_t phase_;  // its number among the phases
    std::size_t run_;    // and of this time among its times
    std::string outer_phase_;
    Timer timer_;
  };
  struct Data;
  /// Number of the phase of that name, a new one if there is none yet.
  std::size_t phase_number(std::string_view name);
  std::unique_ptr<Data> data_;
  Progress* progress_ = nullptr;  // of run(), while it lasts
  int repeat_ = 1;
  bool quiet_ = false;
  bool verbose_ = false;
};

}  // namespace vol::cli
