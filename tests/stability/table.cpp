#include "table.h"

#include <cmath>
#include <cstdio>
#include <ostream>

#include "base/error.h"

namespace vol::stability {
namespace {

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"') result += '"';
    result += c;
  }
  return result + "\"";
}

std::string shown(double x) {
  if (std::isnan(x)) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", x);
  return text;
}

}  // namespace

void Table::row(const std::string& what, const std::string& method, const std::string& precision,
                double error, double bound, const std::string& theory) {
  rows_.push_back({kernel_, what, method, precision, error, bound, theory,
                   std::isfinite(bound) && error <= bound ? "kept" : "NOT KEPT"});
}

void Table::row(const std::string& what, const std::string& method, const std::string& precision,
                const Worst& worst, const std::string& theory) {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  row(what, method, precision, worst.count() > 0 ? worst.error() : nothing, worst.bound(), theory);
}

void Table::refusal(const std::string& what, const std::string& method, const std::string& precision,
                    const std::function<void()>& f) {
  std::string outcome = "NOT KEPT";
  try {
    f();
  } catch (const Error& error) {
    const std::string message = error.what();
    if (!message.empty() && message.find('\n') == std::string::npos) outcome = "refused: " + message;
  }
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  rows_.push_back(
      {kernel_, what, method, precision, nothing, nothing, "an error of one line", std::move(outcome)});
}

void write_header(std::ostream& out) {
  out << "kernel,case,method,precision,error,bound,theory,outcome\n";
}

void write_rows(std::ostream& out, const std::vector<Row>& rows) {
  for (const Row& r : rows) {
    out << quoted(r.kernel) << ',' << quoted(r.what) << ',' << quoted(r.method) << ',' << r.precision << ','
        << shown(r.error) << ',' << shown(r.bound) << ',' << quoted(r.theory) << ',' << quoted(r.outcome)
        << '\n';
  }
}

}  // namespace vol::stability
