#pragma once
#include <filesystem>
#include <string>

#include "base/buffer.h"
#include "base/vec.h"

// The one header behind which FFTW lies. Every transform is cut into one-dimensional ones of a single thread
// each, which parallel_for spreads: results do not depend on the number of threads, as those of FFTW's own
// threaded plans do.
namespace vol::fourier {

/// estimate: the same plan, and so the same bits, every time. measure: faster plans, after seconds of trying,
/// that may differ in the last bits from run to run unless wisdom is kept.
enum class Planning { estimate, measure };

/// Plans found by measuring, from a file; T = float and double each have files of their own.
/// \throws vol::Error where the file cannot be read as wisdom of T
template <class T>
void read_wisdom(const std::filesystem::path& path);
/// What is known now, as such a file holds it.
template <class T>
[[nodiscard]] std::string wisdom();

/// Complex to complex transforms of `length` points, of `columns` neighbouring columns (stride `stride`
/// complex numbers); in place, unnormalised. Columns are brought into the cache a few at a time, side by
/// side: there FFTW finds them one after the other and aligned, wherever they stood, and takes a third of the
/// time.
template <class T>
class ColumnTransform {
 public:
  ColumnTransform(std::int64_t length, bool forward, Planning planning);
  ~ColumnTransform();
  ColumnTransform(const ColumnTransform&) = delete;
  ColumnTransform& operator=(const ColumnTransform&) = delete;
  /// What run() takes besides `data`, and its thread keeps.
  [[nodiscard]] static std::int64_t scratch_bytes(std::int64_t length, std::int64_t columns);
  /// `data`: interleaved complex, the first column's first element.
  void run(T* data, std::int64_t columns, std::int64_t stride) const;

 private:
  std::int64_t length_;
  void* plan_;
};

/// Real to complex rows (forward, exp(-2 pi i k n / length)) or back, in place: a row of 2 (length/2 + 1)
/// reals. Through the cache, too.
template <class T>
class RowTransform {
 public:
  RowTransform(std::int64_t length, bool forward, Planning planning);
  ~RowTransform();
  RowTransform(const RowTransform&) = delete;
  RowTransform& operator=(const RowTransform&) = delete;
  /// What run() takes, and its thread keeps: the same memory as of columns.
  [[nodiscard]] static std::int64_t scratch_bytes(std::int64_t length);
  void run(T* row) const { run(row, row); }
  /// To another place: of a forward transform length + 1 or + 2 reals, of the inverse `length` reals.
  void run(const T* from, T* to) const;

 private:
  std::int64_t length_;
  bool forward_;
  void* plan_;
};

/// Smallest size not below n whose only prime factors are 2, 3, 5 and 7, and which has n's parity if
/// `same_parity`.
[[nodiscard]] std::int64_t next_fast_size(std::int64_t n, bool same_parity = false);

}  // namespace vol::fourier
