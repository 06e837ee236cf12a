#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <iosfwd>
#include <limits>
#include <string>
#include <vector>

namespace vol::stability {

/// Half an ulp of 1: the largest relative error of one rounding.
inline constexpr double kDouble = 0x1p-53, kFloat = 0x1p-24;
template <class T>
inline constexpr double kUnit = sizeof(T) == 4 ? kFloat : kDouble;

/// n u / (1 - n u): the bound of what n roundings in a row do (Higham 2002, lemma 3.1).
[[nodiscard]] inline double gamma(double n, double u) {
  return n * u / (1 - n * u);
}

/// The worst of several comparisons: error and bound of the one that comes nearest to breaking its bound.
class Worst {
 public:
  void add(double error, double bound) {
    const double ratio = error == 0 ? 0 : error / bound;  // NaN stays, and is worst of all
    if (count_++ > 0 && !std::isnan(ratio) && !(ratio > ratio_)) return;
    if (std::isnan(ratio_)) return;
    ratio_ = ratio;
    error_ = error;
    bound_ = bound;
  }
  [[nodiscard]] double error() const { return error_; }
  [[nodiscard]] double bound() const { return bound_; }
  [[nodiscard]] int count() const { return count_; }

 private:
  double ratio_ = 0, error_ = 0, bound_ = 0;
  int count_ = 0;
};

/// One line of the table: what was done at an extreme, how far it was off, and what theory allows.
struct Row {
  std::string kernel, what, method, precision;
  double error, bound;  ///< NaN for a refusal
  std::string theory;   ///< where the bound is from
  std::string outcome;  ///< kept, NOT KEPT, or refused: and the message
};

/// The rows of one kernel.
class Table {
 public:
  explicit Table(std::string kernel) : kernel_(std::move(kernel)) {}

  /// Kept if error <= bound; NaN is not, nor a Worst of nothing.
  void row(const std::string& what, const std::string& method, const std::string& precision, double error,
           double bound, const std::string& theory);
  void row(const std::string& what, const std::string& method, const std::string& precision,
           const Worst& worst, const std::string& theory);
  /// Calls f, which must throw vol::Error with a message of one line.
  void refusal(const std::string& what, const std::string& method, const std::string& precision,
               const std::function<void()>& f);

  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }

 private:
  std::string kernel_;
  std::vector<Row> rows_;
};

/// The header, and a table's rows, as CSV.
void write_header(std::ostream& out);
void write_rows(std::ostream& out, const std::vector<Row>& rows);

}  // namespace vol::stability
