#pragma once
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/record.h"
#include "render/labelled_medium.h"
#include "render/splat_rays.h"

namespace vol::cli {

/// Labels of a volume in its picture, on the command line. Target vol_cli_raycast.
struct LabelOptions {
  std::filesystem::path labels;             ///< --labels
  std::filesystem::path looks;              ///< --label-transfer; empty: default_label_looks()
  std::string use = "alone";                ///< --label-use
  std::string membership = "interpolated";  ///< --label-membership
  std::string splat;                        ///< --splat: labels, or all; empty: none
  std::string support = "1.5v";             ///< --splat-support
  double threshold = 0.5;                   ///< --splat-threshold

  [[nodiscard]] bool any() const { return !labels.empty(); }
};

void add_labels(CLI::App& app, LabelOptions& options);

/// The labels as they were asked for: a medium, and splats in it.
class LabelSet {
 public:
  /// Wrong words are answered before anything is read. \throws vol::Error on labels that are none
  explicit LabelSet(const LabelOptions& options);

  /// Reads the labels and how they look (phase "read"), notes both among the record's inputs and prepares
  /// what is drawn (phase "labels"). Labels that are splatted are not part of the medium.
  /// \throws vol::Error on labels of other dims than the volume, and a label to splat that has no look
  void load(const volume::GridGeometry& geometry, Record& record);

  /// nullptr: no labels.
  [[nodiscard]] const render::LabelledMedium* medium() const { return medium_.get(); }
  /// nullptr: no splats.
  [[nodiscard]] const render::SplatRays* splats() const { return splats_.get(); }

 private:
  [[nodiscard]] std::vector<bool> splatted(const std::vector<render::LabelLook>& looks) const;

  const LabelOptions& options_;
  std::vector<int> chosen_;  // to be splatted; empty: all, where any are
  std::unique_ptr<const render::LabelledMedium> medium_;
  std::unique_ptr<const render::SplatRays> splats_;
};

}  // namespace vol::cli
