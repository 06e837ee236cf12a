#pragma once
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/record.h"

namespace vol::cli {

struct Record::Data {
  std::string tool;
  std::vector<std::string> command;
  nlohmann::json options = nlohmann::json::object();   ///< all, as resolved
  nlohmann::json content = nlohmann::json::object();   ///< those that determine the content
  std::vector<std::string> inputs, outputs;
  std::vector<std::pair<std::string, std::vector<double>>> phases;
  nlohmann::json counts = nlohmann::json::object();
  nlohmann::json result = nlohmann::json::object();
  nlohmann::json error = nlohmann::json::object();
  nlohmann::json seed;
  nlohmann::json device;
  bool checksum = false;
  Timer total;
};

/// The side of the record that only run() sees.
class Runner {
 public:
  struct Setup {
    std::string tool;
    std::vector<std::string> command;
    int repeat = 1;
    bool checksum = false, quiet = false, verbose = false;
  };
  static void configure(Record& record, const Setup& setup, const CLI::App& app);
  /// Phases of the record show on `progress` from now on; null: nowhere.
  static void show(Record& record, Progress* progress);
  /// The record as JSON (stats.schema.json).
  [[nodiscard]] static nlohmann::json to_json(const Record& record);
};

}  // namespace vol::cli
