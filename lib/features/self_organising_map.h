#pragma once
#include <cstdint>
#include <vector>

#include "features/pca.h"

namespace vol::features {

/// Number of the row of `centres` nearest to a vector; ties go to the first.
[[nodiscard]] Eigen::Index nearest(const Samples& centres,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& vector);

/// Of a map: what training keeps of each pair of them is a number.
inline constexpr int kMostUnits = 4096;

enum class MapGrid { rectangular, hexagonal };

struct MapOptions {
  int columns = 6, rows = 4;
  MapGrid grid = MapGrid::rectangular;
  int epochs = 40;
  double last_radius = 0.5;  ///< of the neighbourhood, in distances between units
};

/// A self-organising map (Kohonen 1995): units on a plane grid, each with a vector, so that neighbours on the
/// grid hold vectors that are alike. Unit u stands in column u mod columns and row u / columns; of a
/// hexagonal grid odd rows are shifted by half a unit and rows are sqrt(3)/2 apart.
struct SelfOrganisingMap {
  MapOptions options;
  Samples units;                   ///< columns rows x components
  std::vector<std::int64_t> hits;  ///< samples nearest to each unit
  double quantisation_error = 0;   ///< root mean square distance of the samples to their units
  double topographic_error =
      0;  ///< share of the samples whose two nearest units are no neighbours on the grid

  [[nodiscard]] double grid_distance(int a, int b) const;
  /// Next to each other: four or six neighbours, and on a rectangular grid those across the corner.
  [[nodiscard]] bool are_neighbours(int a, int b) const;
};

/// Batch training: in each epoch every sample goes to its nearest unit and every unit to the mean of all
/// samples, weighted by exp(-g^2 / (2 r^2)), g the distance on the grid from the sample's unit; r falls
/// geometrically from half the grid's longer side to the last radius. It begins with the units spread over
/// the plane of the first two components, two standard deviations either way, so nothing is drawn at random;
/// sums are in double in a fixed order, so nothing depends on threads. Throws vol::Error on an empty grid or
/// one of more than kMostUnits, on no samples.
[[nodiscard]] SelfOrganisingMap train_map(const Samples& samples, const MapOptions& options);

}  // namespace vol::features
