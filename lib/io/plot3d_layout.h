#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "io/grid.h"

// Private to lib/io: how a PLOT3D file is laid out, found by fitting all layouts to its bytes.
namespace vol::io {

/// One way in which the numbers may lie.
struct Plot3dForm {
  bool ascii = false, big_endian = false, records = false, multi_block = false, iblank = false;
  int bits = 32;
  int axes = 3;           ///< 2: a 2-D grid
  bool overflow = false;  ///< the solution as OVERFLOW writes it: number of variables, longer block header

  [[nodiscard]] std::string text() const;
};

/// The numbers of a file: bytes of one form, or of text the numbers themselves.
class Plot3dNumbers {
 public:
  /// \throws vol::Error on text that is no number
  Plot3dNumbers(std::string name, std::vector<std::byte> bytes);
  [[nodiscard]] bool ascii() const { return ascii_; }
  /// In bytes, or in numbers of text.
  [[nodiscard]] std::int64_t size() const;
  [[nodiscard]] std::int64_t integer_size() const { return ascii_ ? 1 : 4; }
  [[nodiscard]] std::int64_t real_size(const Plot3dForm& form) const { return ascii_ ? 1 : form.bits / 8; }
  [[nodiscard]] std::int64_t integer(std::int64_t at, const Plot3dForm& form) const;
  [[nodiscard]] double real(std::int64_t at, const Plot3dForm& form) const;
  /// Whether nothing but zeros stands there and after: padding.
  [[nodiscard]] bool zero_from(std::int64_t at) const;
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::vector<std::byte> bytes_;
  std::vector<double> numbers_;
  bool ascii_;
  void scan();
};

/// Where a form that fits finds what.
struct Plot3dFit {
  Plot3dForm form;
  std::vector<Dims> dims;               ///< of each block; the third 1 for a 2-D grid
  std::vector<std::int64_t> data;       ///< position of each block's data
  std::vector<std::int64_t> reference;  ///< of each block's mach, alpha, re, time (solutions)
  std::int64_t left_over = 0;
};

/// The form of the file. \param expected  a solution, of a grid of these sizes; empty: positions
/// \throws vol::Error where none or several fit, saying what was tried, and for 2-D grids
[[nodiscard]] Plot3dFit fit_plot3d(const Plot3dNumbers& numbers, const Plot3dLayout& known,
                                   const std::vector<Dims>& expected);

}  // namespace vol::io
