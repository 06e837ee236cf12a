#pragma once
#include <cstdint>

namespace vol::wavelet {

inline constexpr std::int64_t kFootprintRows = 4;
inline constexpr std::int64_t kFootprintColumns = 16;

/// sum[r][c] += sum over j in [begin, end) of a[j][r] b[j][c], r below kFootprintRows and c below
/// kFootprintColumns, rows of `sum` a stride apart.
void add_product(const double* a, const double* b, std::int64_t begin, std::int64_t end, double* sum,
                 std::int64_t stride);

}  // namespace vol::wavelet
