// forward_difference_drift: how far forward-differenced points drift from the solid, as a table (CSV): along
// one axis and in three nested ones, set up from control points and from samples, float and double; the
// largest of 16 solids with jittered corners, over the size of the cell. The last column is float with
// coordinates 1000 cells off.
#include <cstdio>

#include "../curvilinear/drift.h"
#include "../curvilinear/random_block.h"

using namespace vol;
using namespace vol::curvilinear;

int main() {
  std::vector<Solid> solids;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    const Block block = random_block({4, 4, 4}, seed);
    solids.push_back(Solids(block, block.arrays[0].values, CellKind::tricubic, 1)({1, 1, 1}));
  }
  const auto worst = [&](const auto& drift_of) {
    double largest = 0;
    for (const Solid& solid : solids) largest = std::max(largest, drift_of(solid));
    return largest;
  };
  std::puts("axes,steps,float_control_points,float_samples,double_control_points,double_samples,float_far");
  for (const int axes : {1, 3}) {
    for (int n = 1; n <= kMostSteps; n *= 4) {
      const auto of = [&](SetUp set_up, auto type) {
        using T = decltype(type);
        return worst([&](const Solid& s) { return drift<T>(s, n, axes, set_up, local_origin(s)); });
      };
      const double far = worst([&](const Solid& s) {
        Point4 origin = local_origin(s);
        origin.head<3>() += 1000 * s.hull().size();
        return drift<float>(s, n, axes, SetUp::control_points, origin);
      });
      std::printf("%d,%d,%.2g,%.2g,%.2g,%.2g,%.2g\n", axes, n, of(SetUp::control_points, 0.0F),
                  of(SetUp::samples, 0.0F), of(SetUp::control_points, 0.0), of(SetUp::samples, 0.0), far);
    }
  }
}
