#include "cli/run.h"

#include <unistd.h>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <map>
#include <new>
#include <optional>

#include "base/error.h"
#include "base/parallel.h"
#include "base/simd.h"
#include "base/version.h"
#include "cli/progress.h"
#include "cli/runner.h"
#include "io/file.h"

namespace vol::cli {
namespace {

enum ExitStatus : int { kDone = 0, kCouldNot = 2, kNoDevice = 3 };

/// Leaves nothing half-written, then dies of the signal as if it had not been caught: status 128 + signal.
extern "C" void on_signal(int signal) {
  io::remove_uncommitted_outputs();
  clear_progress();
  ::_exit(128 + signal);
}

void catch_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, on_signal);
  std::signal(SIGPIPE, SIG_IGN);  // a reader that leaves early is a failed write, reported like any other
}

struct CommonOptions {
  std::string stats;
  int threads = 0;
  int repeat = 1;
  bool checksum = false;
  bool quiet = false;
  bool verbose = false;
};

void add_common_options(CLI::App& app, const ToolInfo& tool, CommonOptions& common) {
  app.name(tool.name);
  app.set_help_flag("-h,--help", "Print this help and exit");
  app.set_version_flag(
      "--version",
      std::string(tool.name) + " (precis) " + std::string(version()) + " " + std::string(commit()),
      "Print the version and exit");
  app.set_config("--config", "", "Read options from a file (TOML: option = value)");
  app.allow_config_extras(CLI::config_extras_mode::error);
  app.add_option("--stats", common.stats,
                 "Write the stats record of the run as JSON to FILE, - for standard error")
      ->type_name("FILE");
  app.add_flag("--checksum", common.checksum, "Put the SHA-256 of inputs and outputs into the stats record");
  app.add_option("--threads", common.threads,
                 "Number of threads, 0 for one a core; results do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  if (tool.repeats) {
    app.add_option("--repeat", common.repeat, "Run the compute phase N times and record every time")
        ->type_name("N")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
  }
  app.add_flag("--quiet", common.quiet, "No messages but errors and warnings");
  app.add_flag("--verbose", common.verbose, "Say more on standard error");
  for (const char* name :
       {"--help", "--version", "--config", "--stats", "--checksum", "--threads", "--quiet", "--verbose"}) {
    app.get_option(name)->group("Run");
  }
  if (tool.repeats) app.get_option("--repeat")->group("Run");
  std::string footer = app.get_footer();  // what the tool itself has to say after its options
  if (!footer.empty()) footer += "\n\n";
  footer += std::string("Example:\n  ") + tool.example;
  if (*tool.references != '\0') footer += std::string("\n\nReferences: ") + tool.references;
  footer += "\n\nExit status: 0 done, 1 the answer is no, 2 could not do it, 3 a device is missing.";
  app.footer(footer);
  app.get_formatter()->column_width(30);
}

/// The file of --stats, opened before the work, so that a place that cannot be written costs nothing.
class Stats {
 public:
  explicit Stats(const std::string& path) : is_asked_for_(!path.empty()) {
    if (is_asked_for_ && !io::is_standard_stream(path)) file_.emplace(path);
  }
  void write(const Record& record) {
    if (!is_asked_for_) return;
    const auto replace = nlohmann::json::error_handler_t::replace;  // a path may be no UTF-8
    const std::string text = Runner::to_json(record).dump(2, ' ', false, replace) + "\n";
    if (!file_) {
      std::fputs(text.c_str(), stderr);
      if (std::fflush(stderr) != 0 || std::ferror(stderr) != 0)
        throw Error("the stats record cannot be written to standard error");
      return;
    }
    file_->write(std::string_view(text));
    file_->commit();
  }

 private:
  bool is_asked_for_;
  std::optional<io::OutputFile> file_;
};

/// One line, whatever a library's exception holds.
int complain(const char* tool, std::string message) {
  for (char& c : message) {
    if (c == '\n') c = ' ';
    if ((c >= 0 && c < ' ') || c == '\x7f') c = '?';  // of a file that is no text
  }
  while (message.ends_with(' ')) message.pop_back();
  std::fprintf(stderr, "%s: %s\n", tool, message.c_str());
  return kCouldNot;
}

/// Whether all that was printed is out; a flush alone forgets what failed before it.
bool said_all() {
  return std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
}

constexpr std::size_t kHelpColumns = 100, kHelpTextColumn = 30;

/// CLI11 does not break lines. What is longer than kHelpColumns is broken at a space, or within a list of
/// choices after a comma, and goes on under the column that it stands in; the example stays a command that
/// runs.
std::string wrap_help(const std::string& help) {
  std::string wrapped;
  bool example = false;
  for (std::size_t begin = 0; begin < help.size();) {
    const std::size_t end = std::min(help.find('\n', begin), help.size());
    std::string line = help.substr(begin, end - begin);
    begin = end + 1;
    example = line == "Example:" || (example && !line.empty());
    const std::string go_on = example ? " \\" : "";
    const std::size_t columns = kHelpColumns - go_on.size();
    const bool entry = line.starts_with("  ");
    const bool has_text =
        entry && line.size() > kHelpTextColumn && line.substr(kHelpTextColumn - 2, 2) == "  ";
    const std::size_t indent = has_text ? kHelpTextColumn : entry ? 6 : 0;
    while (line.size() > kHelpColumns) {
      std::size_t cut = line.rfind(' ', columns);
      if (cut == std::string::npos || cut <= indent) cut = line.rfind(',', columns - 1);
      if (cut == std::string::npos || cut <= indent) break;  // one long word
      const std::size_t next = cut + 1;
      if (line[cut] == ',') ++cut;
      wrapped += line.substr(0, cut) + go_on + "\n";
      line = std::string(indent, ' ') + line.substr(next);
    }
    wrapped += line + "\n";
  }
  return wrapped;
}

/// CLI11 numbers its errors from 100 and prints two lines; a user gets one line and a 2.
int usage_error(const CLI::App& app, const ToolInfo& tool, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) {
    if (dynamic_cast<const CLI::CallForVersion*>(&error) != nullptr) {
      std::printf("%s\n", error.what());
    } else {
      std::fputs(wrap_help(app.help()).c_str(), stdout);
    }
    return said_all() ? kDone : complain(tool.name, "cannot write to standard output");
  }
  std::string message = error.what();
  // CLI11 does not say in which file of options.
  if (dynamic_cast<const CLI::ConfigError*>(&error) != nullptr) {
    constexpr std::string_view kUnknown = "INI was not able to parse ";
    if (message.starts_with(kUnknown)) message = "unknown option '" + message.substr(kUnknown.size()) + "'";
    message = app.get_config_ptr()->results().front() + ": " + message;
  }
  return complain(tool.name, message + " (see " + tool.name + " --help)");
}

/// CLI11 takes an empty value for 0; nothing here has a use for one.
void refuse_empty_values(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    for (const auto& value : option->results()) {
      if (value.empty()) throw Error(option->get_name() + ": the value is empty");
    }
  }
}

/// Of two outputs in one place the second would take the first's, and nobody would know.
void refuse_shared_outputs(const CLI::App& app) {
  std::map<std::filesystem::path, std::string> owners;
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = option->get_name();
    const bool is_output = name == "--output" || name == "--difference" || name.ends_with("-output");
    if (!is_output && name != "--stats") continue;
    for (const auto& value : option->results()) {
      const bool is_stream = io::is_standard_stream(value);
      if (is_stream && !is_output) continue;  // a record goes to standard error
      std::filesystem::path place = value;
      if (!is_stream) {
        std::error_code failure;
        if (std::filesystem::exists(value, failure) && !std::filesystem::is_regular_file(value, failure)) {
          continue;  // a device or a pipe takes everything; of a folder others complain
        }
        place = std::filesystem::absolute(value).lexically_normal();
        auto canonical = std::filesystem::weakly_canonical(place, failure);
        if (!failure) place = std::move(canonical);
      }
      const auto [owner, is_new] = owners.emplace(place, name);
      if (is_new) continue;
      throw Error(io::output_name(value) + ": is where both " + owner->second + " and " + name +
                  " would go; give them different names");
    }
  }
}

/// Does the work with its progress on standard error; the line is gone before anything else is said.
int watched(Record& record, const ToolInfo& tool, bool quiet, const std::function<int(Record&)>& work) {
  if (quiet) return work(record);
  struct Shown {
    Record& record;
    Progress progress;
    Shown(Record& r, const char* name) : record(r), progress(name) { Runner::show(record, &progress); }
    ~Shown() { Runner::show(record, nullptr); }
  };
  const Shown shown(record, tool.name);
  return work(record);
}

}  // namespace

int run(CLI::App& app, const ToolInfo& tool, int argc, char** argv, const std::function<int(Record&)>& work) {
  catch_signals();
  CommonOptions common;
  Record record;
  try {
    add_common_options(app, tool, common);
    app.parse(argc, argv);
    refuse_empty_values(app);
    refuse_shared_outputs(app);
    set_thread_count(common.threads);
    if (const char* most = std::getenv("PRECIS_SIMD")) limit_simd(most);
    Runner::configure(record,
                      {.tool = tool.name,
                       .command = {argv, argv + argc},
                       .repeat = common.repeat,
                       .checksum = common.checksum,
                       .quiet = common.quiet,
                       .verbose = common.verbose},
                      app);
    Stats stats(common.stats);
    const int status = watched(record, tool, common.quiet, work);
    if (!said_all()) throw Error("cannot write to standard output");
    stats.write(record);
    return status;
  } catch (const CLI::ParseError& error) {
    return usage_error(app, tool, error);
  } catch (const DeviceError& error) {
    (void)complain(tool.name, error.what());
    return kNoDevice;
  } catch (const std::bad_alloc&) {
    return complain(tool.name, "not enough memory");
  } catch (const std::exception& error) {
    return complain(tool.name, error.what());
  }
}

}  // namespace vol::cli
