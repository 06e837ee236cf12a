#pragma once
#include <cstdint>

// The inner loops of the transform: whole rows, any vector width, chosen at run time. Products and sums are
// rounded one by one (no fused multiply-add) in the order of the rows, so that the result has the same bits
// on every machine and for every cut of a row.
namespace vol::wavelet {

/// low[i] = sum_r a[r] rows[r][i] and high[i] = sum_r b[r] rows[r][i], i < count; high may be null.
/// Analysis and synthesis along any axis have this form: along y and z with rows of the volume, along x with
/// shifted views of its even and odd samples. Outputs may not overlap the rows.
void combine(const float* const* rows, const float* a, const float* b, int taps, std::int64_t count,
             float* low, float* high);
void combine(const double* const* rows, const double* a, const double* b, int taps, std::int64_t count,
             double* low, double* high);

/// even[i] = x[2i] and odd[i] = x[2i+1] for the `count` samples of x; even gets the last of an odd count.
void deinterleave(const float* x, std::int64_t count, float* even, float* odd);
void deinterleave(const double* x, std::int64_t count, double* even, double* odd);

/// x[2i] = even[i], x[2i+1] = odd[i] for `count` pairs.
void interleave(const float* even, const float* odd, std::int64_t count, float* x);
void interleave(const double* even, const double* odd, std::int64_t count, double* x);

}  // namespace vol::wavelet
