#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/run.h"
#include "scarce_memory.h"

namespace vol::cli {
namespace {

using nlohmann::json;

struct Outcome {
  int status;
  json record;
  json provenance;  ///< "precis.options"
};

/// Runs a tool of two flags, a number and an option of the group Files, with --stats.
Outcome run_with(std::vector<std::string> arguments) {
  static int runs = 0;
  const auto stats = std::filesystem::temp_directory_path() /
                     ("precis-record-" + std::to_string(::getpid()) + "-" + std::to_string(++runs) + ".json");
  arguments.insert(arguments.begin(), "tool");
  arguments.insert(arguments.end(), {"--stats", stats.string()});
  std::vector<char*> argv;
  for (auto& argument : arguments) argv.push_back(argument.data());
  CLI::App app{"A tool."};
  bool fast = false, keep = false;
  double step = 0.5;
  std::string path;
  app.add_flag("--fast", fast, "")->group("Method");
  app.add_flag("--keep", keep, "")->group("Files");
  app.add_option("--step", step, "")->capture_default_str();
  app.add_option("--path", path, "")->group("Files");
  Outcome outcome;
  outcome.status = run(app, {.name = "tool", .example = "tool"}, static_cast<int>(argv.size()), argv.data(),
                       [&](Record& record) {
                         record.timed("sweep", [] {});
                         outcome.provenance = json::parse(record.provenance().at("precis.options"));
                         return 0;
                       });
  std::ifstream(stats) >> outcome.record;
  std::filesystem::remove(stats);
  return outcome;
}

TEST(Record, FlagsAreTrueOrFalse) {
  const auto given = run_with({"--fast", "--keep", "--quiet"});
  ASSERT_EQ(given.status, 0);
  for (const char* flag : {"fast", "keep", "quiet"}) EXPECT_EQ(given.record["options"][flag], true) << flag;
  const auto absent = run_with({});
  for (const char* flag : {"fast", "keep", "quiet", "verbose", "checksum"}) {
    EXPECT_EQ(absent.record["options"][flag], false) << flag;
  }
  EXPECT_EQ(run_with({"--fast=false"}).record["options"]["fast"], false);
}

TEST(Record, OptionsAreThoseGivenElseTheDefaults) {
  EXPECT_EQ(run_with({}).record["options"]["step"], "0.5");
  EXPECT_EQ(run_with({"--step", "0.25"}).record["options"]["step"], "0.25");
}

TEST(Record, ProvenanceHoldsWhatDeterminesTheContentAlone) {
  const auto outcome = run_with({"--fast", "--threads", "1", "--path", "somewhere"});
  EXPECT_EQ(outcome.provenance, (json{{"fast", true}, {"step", "0.5"}}));
}

TEST(Record, PhasesAreTimed) {
  const auto phases = run_with({}).record["time_s"]["phases"];
  ASSERT_TRUE(phases.contains("sweep"));
  EXPECT_EQ(phases["sweep"].size(), 1u);
}

/// A failed allocation is on its way while the times of the phases it leaves are taken.
TEST(Record, APhaseEndsWithoutMemory) {
  Record record;
  const auto phase = [&] {
    record.timed("a phase with a long name", [&] {
      record.timed("another phase with a long name", [] {
        no_memory_is_left = true;
        throw std::bad_alloc();
      });
    });
  };
  bool caught = false;
  try {
    phase();
  } catch (const std::bad_alloc&) {
    caught = true;
  }
  no_memory_is_left = false;
  EXPECT_TRUE(caught);
}

}  // namespace
}  // namespace vol::cli
