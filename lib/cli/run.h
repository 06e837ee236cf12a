#pragma once
#include <CLI/CLI.hpp>
#include <functional>

#include "cli/record.h"

namespace vol::cli {

/// What a tool is, beyond its options.
struct ToolInfo {
  const char* name;                 ///< "vol-dwt"
  const char* example;              ///< one command that runs as it stands, shown by --help
  const char* references = "";      ///< papers, shown by --help
  bool repeats = false;             ///< offers --repeat N (the tool uses Record::repeated)
};

/// Parses the command line, runs `work`, writes the stats record, and turns every outcome into an exit status:
/// what `work` returns (0 done, 1 the answer is no), 2 could not do it (usage, data, files), 3 a device is
/// missing, 128 + signal when interrupted. The only place with a try/catch around a tool.
///
/// The record is opened before the work and written last, after the outputs and what goes to standard output:
/// it holds their sizes, hashes and times, and says of a run that it is done. A place that cannot be opened is
/// thus refused before any work. A record that fails only then (a full disk) is an error like any other, one
/// line and status 2; the outputs, whole by then, stay: they are right, and may have taken hours.
///
/// Adds the options every tool has: --stats --checksum --threads --repeat --config --quiet --verbose --version.
/// Options in a CLI11 group named "Files" and the ones above are left out of the provenance.
///
/// A main of a tool:
///     CLI::App app{"Orthonormal 3D wavelet transform of a scalar field."};
///     app.add_option("input", input, "...")->required()->group("Files"); ...
///     return cli::run(app, {.name = "vol-dwt", .example = "vol-dwt head.nrrd -o c.vdb"}, argc, argv,
///                     [&](cli::Record& record) { ...; return 0; });
int run(CLI::App& app, const ToolInfo& tool, int argc, char** argv, const std::function<int(Record&)>& work);

}  // namespace vol::cli
