#include "cli/record.h"

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <thread>

#include "base/parallel.h"
#include "base/simd.h"
#include "base/version.h"
#include "cli/progress.h"
#include "cli/runner.h"
#include "cli/sha256.h"
#include "io/file.h"

namespace vol::cli {
namespace {

using nlohmann::json;

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(std::min(line.size(), line.find(':') + 2));
  }
  return "unknown";
}

/// Of this program alone. What getrusage() says begins with the memory of the process that started it, which
/// for a script that holds volumes is the larger one.
std::int64_t peak_rss_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::atoll(line.c_str() + 6) * 1024;
  }
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

std::string file_sha256(const std::string& path) {
  io::InputFile file(path);
  Sha256 hash;
  std::vector<std::byte> part(1 << 20);
  while (const std::size_t n = file.read(part.data(), part.size())) hash.update(part.data(), n);
  return hash.hex();
}

json describe_files(const std::vector<std::string>& paths, bool checksum) {
  json list = json::array();
  for (const auto& path : paths) {
    json entry = {{"path", path}};
    std::error_code ignored;
    if (std::filesystem::is_regular_file(path, ignored)) {
      entry["bytes"] = std::filesystem::file_size(path, ignored);
      if (checksum) entry["sha256"] = file_sha256(path);
    }
    list.push_back(std::move(entry));
  }
  return list;
}

/// What the option holds after parsing: given values, else the default; a flag is true or false.
json option_value(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return option.count() > 0 && option.as<bool>();
  const auto given = option.count() > 0 ? option.results() : std::vector<std::string>{};
  if (given.empty()) return option.get_default_str();
  if (given.size() == 1) return given.front();
  return given;
}

double sum(const std::vector<double>& times) {
  double total = 0;
  for (const double t : times) total += t;
  return total;
}

double median(std::vector<double> times) {
  std::sort(times.begin(), times.end());
  const std::size_t n = times.size();
  return n % 2 == 1 ? times[n / 2] : 0.5 * (times[n / 2 - 1] + times[n / 2]);
}

/// time_s: read, write and total are sums; compute is the sum of the medians of its phases (one run's worth,
/// however often --repeat ran it); phases keeps every time.
json describe_times(const std::vector<std::pair<std::string, std::vector<double>>>& phases, double total) {
  double read = 0, write = 0, compute = 0;
  json all = json::object();
  for (const auto& [name, times] : phases) {
    if (name == "read") {
      read = sum(times);
    } else if (name == "write") {
      write = sum(times);
    } else {
      compute += median(times);
      all[name] = times;
    }
  }
  return {{"read", read}, {"compute", compute}, {"write", write}, {"total", total}, {"phases", all}};
}

}  // namespace

Record::Stopwatch::Stopwatch(Record& record, std::string_view phase)
    : record_(record), phase_(record.phase_number(phase)) {
  auto& times = record_.data_->phases[phase_].second;
  run_ = times.size();
  times.push_back(0);
  if (record_.progress_ != nullptr) outer_phase_ = record_.progress_->phase(std::string(phase));
}

Record::Stopwatch::~Stopwatch() noexcept {
  record_.data_->phases[phase_].second[run_] = timer_.seconds();
  if (record_.progress_ != nullptr) (void)record_.progress_->phase(std::move(outer_phase_));
}

Record::Record() : data_(std::make_unique<Data>()) {}
Record::~Record() = default;

std::size_t Record::phase_number(std::string_view name) {
  auto& phases = data_->phases;
  const auto found =
      std::find_if(phases.begin(), phases.end(), [&](const auto& phase) { return phase.first == name; });
  if (found != phases.end()) return static_cast<std::size_t>(found - phases.begin());
  phases.emplace_back(name, std::vector<double>{});
  return phases.size() - 1;
}

void Record::count(std::string_view name, std::int64_t value) {
  data_->counts[std::string(name)] = value;
}
void Record::result(std::string_view name, const json& value) {
  data_->result[std::string(name)] = value;
}
void Record::error(std::string_view name, const json& value) {
  data_->error[std::string(name)] = value;
}
void Record::seed(std::uint64_t value) {
  data_->seed = value;
}
void Record::device(std::string_view name) {
  data_->device = std::string(name);
}
void Record::input(const std::filesystem::path& path) {
  data_->inputs.push_back(path.string());
}
void Record::output(const std::filesystem::path& path) {
  data_->outputs.push_back(path.string());
}
void Record::resolved(std::string_view name, const json& value) {
  data_->options[std::string(name)] = value;
  data_->content[std::string(name)] = value;
}

std::map<std::string, std::string> Record::provenance() const {
  return {{"precis.tool", data_->tool},
          {"precis.version", std::string(version())},
          {"precis.options", data_->content.dump()}};
}

void Record::say(std::string_view message) const {
  if (!quiet_) std::fprintf(stderr, "%.*s\n", static_cast<int>(message.size()), message.data());
}

void Record::warn(std::string_view message) const {
  std::fprintf(stderr, "%s: warning: %.*s\n", data_->tool.c_str(), static_cast<int>(message.size()),
               message.data());
}

void Runner::show(Record& record, Progress* progress) {
  record.progress_ = progress;
}

void Runner::configure(Record& record, const Setup& setup, const CLI::App& app) {
  record.repeat_ = setup.repeat;
  record.quiet_ = setup.quiet;
  record.verbose_ = setup.verbose;
  auto& data = *record.data_;
  data.tool = setup.tool;
  data.command = setup.command;
  data.checksum = setup.checksum;
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_name(false, false).substr(option->get_positional() ? 0 : 2);
    if (name == "help" || name == "version" || name == "config") continue;
    const json value = option_value(*option);
    data.options[name] = value;
    if (option->get_group() != "Files" && option->get_group() != "Run") data.content[name] = value;
  }
}

json Runner::to_json(const Record& record) {
  const auto& d = *record.data_;
  return {{"tool", d.tool},
          {"version", version()},
          {"commit", commit()},
          {"command", d.command},
          {"options", d.options},
          {"host",
           {{"cpu", cpu_model()},
            {"cores", std::thread::hardware_concurrency()},
            {"threads", thread_count()},
            {"simd", simd_name()},
            {"device", d.device}}},
          {"inputs", describe_files(d.inputs, d.checksum)},
          {"outputs", describe_files(d.outputs, d.checksum)},
          {"time_s", describe_times(d.phases, d.total.seconds())},
          {"peak_rss_bytes", peak_rss_bytes()},
          {"counts", d.counts},
          {"result", d.result},
          {"error", d.error},
          {"seed", d.seed}};
}

}  // namespace vol::cli
