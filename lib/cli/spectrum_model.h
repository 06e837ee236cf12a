#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/record.h"
#include "fourier/models.h"
#include "fourier/spectrum.h"

namespace vol::cli {

/// Which spectra of a volume are asked for on the command line. Target vol_cli_fft.
struct SpectrumModelOptions {
  std::string shading;             ///< --shading
  std::string bezier;              ///< --bezier: a number, or a file
  std::vector<double> range;       ///< --range
  std::vector<std::string> bands;  ///< --bands
  bool edges = false;              ///< --edges
};

void add_spectrum_model(CLI::App& app, SpectrumModelOptions& options);

/// The model as it was asked for.
class SpectrumModel {
 public:
  /// Wrong words are answered before a volume is read; a file of curves is noted among the record's inputs.
  /// \throws vol::Error on bands that are none, and curves that no spectra add up to
  SpectrumModel(const SpectrumModelOptions& options, Record& record);

  /// How many spectra of() will name.
  [[nodiscard]] std::int64_t spectra() const;
  /// Of this volume, which must live longer; what readers of Bezier spectra must know goes into `info`.
  [[nodiscard]] fourier::Model of(const volume::Volume& volume, fourier::SpectrumInfo& info,
                                  Record& record) const;

 private:
  const SpectrumModelOptions& options_;
  std::vector<fourier::Band> bands_;
  int points_ = 0;                      // of Bezier curves; 0: none
  std::optional<volume::Range> range_;  // of these; nothing: the volume's
};

}  // namespace vol::cli
