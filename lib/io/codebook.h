#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "features/codebook.h"

namespace vol::io {

/// A codebook as YAML, numbers with all their digits: what is read labels exactly as what was written.
void write_codebook(const std::filesystem::path& path, const features::Codebook& codebook,
                    const std::map<std::string, std::string>& attributes);

/// Inverse of write_codebook(). Throws vol::Error naming the file and, for YAML that is not a codebook, the
/// line.
[[nodiscard]] features::Codebook read_codebook(const std::filesystem::path& path);

/// The feature vector of every voxel as an NRRD of four axes, the features first, f32, in the volume's own
/// values. Written row by row: takes no memory. \throws vol::Error on a value that f32 does not hold
void write_features(const std::filesystem::path& path, const features::FeatureField& field,
                    const std::map<std::string, std::string>& attributes);

}  // namespace vol::io
