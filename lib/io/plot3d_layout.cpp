#include "io/plot3d_layout.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <optional>

#include "base/error.h"
#include "io/header_text.h"

namespace vol::io {
namespace {

constexpr std::int64_t kMostBlocks = 1 << 20;
/// Numbers that text may stand for with repeat counts, per byte: above it is a bomb.
constexpr std::int64_t kMostNumbersPerByte = 64;

bool looks_like_text(const std::vector<std::byte>& bytes) {
  const std::size_t n = std::min<std::size_t>(bytes.size(), 4096);
  return n > 0 && std::all_of(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n), [](std::byte b) {
           const auto c = static_cast<unsigned char>(b);
           return c == '\t' || c == '\n' || c == '\r' || (c >= ' ' && c < 127);
         });
}

/// Goes over a file in one form: records and their marks, block by block.
class Walk {
 public:
  Walk(const Plot3dNumbers& numbers, const Plot3dForm& form) : numbers_(numbers), form_(form) {}

  std::optional<Plot3dFit> fit(bool solution) {
    Plot3dFit fit;
    fit.form = form_;
    std::int64_t blocks = 1, at = 0;
    if (form_.multi_block) {
      if (!chunk(numbers_.integer_size(), at)) return {};
      blocks = numbers_.integer(at, form_);
      if (blocks < 1 || blocks > kMostBlocks) return {};
    }
    const std::int64_t integers = form_.axes * blocks + (form_.overflow ? 2 : 0);
    if (!chunk(integers * numbers_.integer_size(), at)) return {};
    std::int64_t variables = solution ? form_.axes + 2 : form_.axes;
    if (form_.overflow) {
      variables = numbers_.integer(at + (integers - 2) * numbers_.integer_size(), form_);
      if (variables < 5 || variables > 1000) return {};
    }
    for (std::int64_t b = 0; b < blocks; ++b) {
      Dims dims{1, 1, 1};
      double count = 1;
      for (int a = 0; a < form_.axes; ++a) {
        dims[static_cast<std::size_t>(a)] =
            numbers_.integer(at + (b * form_.axes + a) * numbers_.integer_size(), form_);
        if (dims[static_cast<std::size_t>(a)] < 1) return {};
        count *= static_cast<double>(dims[static_cast<std::size_t>(a)]);
      }
      if (count > static_cast<double>(numbers_.size())) return {};
      fit.dims.push_back(dims);
    }
    const std::int64_t real = numbers_.real_size(form_);
    std::int64_t last = 0;
    for (const Dims& dims : fit.dims) {
      const std::int64_t points = dims[0] * dims[1] * dims[2];
      if (solution) {
        // OVERFLOW: 15 reals and an integer.
        if (!chunk(form_.overflow ? 15 * real + numbers_.integer_size() : 4 * real, at)) return {};
        fit.reference.push_back(at);
      }
      if (!chunk(points * (variables * real + (form_.iblank ? numbers_.integer_size() : 0)), at)) return {};
      fit.data.push_back(at);
      last = points * real;
    }
    fit.left_over = numbers_.size() - position_;
    // Padding is zeros: anything else left over is data of another layout, or of a file cut short.
    if (fit.left_over >= std::max<std::int64_t>(last, 1) || !numbers_.zero_from(position_)) return {};
    return fit;
  }

 private:
  const Plot3dNumbers& numbers_;
  const Plot3dForm& form_;
  std::int64_t position_ = 0;

  /// The next `n` units, between the marks of a record where there are records; where they begin.
  bool chunk(std::int64_t n, std::int64_t& begin) {
    const std::int64_t mark = form_.records ? 4 : 0;
    if (n > numbers_.size() - position_ - 2 * mark) return false;
    begin = position_ + mark;
    if (form_.records &&
        (numbers_.integer(position_, form_) != n || numbers_.integer(begin + n, form_) != n)) {
      return false;
    }
    position_ = begin + n + mark;
    return true;
  }
};

template <class T>
bool allows(const std::optional<T>& known, T value) {
  return !known || *known == value;
}

std::vector<Plot3dForm> forms(const Plot3dNumbers& numbers, const Plot3dLayout& known, bool solution) {
  std::vector<Plot3dForm> all;
  const int combinations = 1 << 7;
  for (int n = 0; n < combinations; ++n) {
    Plot3dForm f;
    f.ascii = numbers.ascii();
    f.big_endian = (n & 1) != 0;
    f.records = (n & 2) != 0;
    f.multi_block = (n & 4) != 0;
    f.iblank = (n & 8) != 0;
    f.bits = (n & 16) != 0 ? 64 : 32;
    f.axes = (n & 32) != 0 ? 2 : 3;
    f.overflow = (n & 64) != 0;
    if (f.ascii && (f.big_endian || f.records || f.bits == 64 || f.overflow)) continue;
    if (solution ? f.iblank : f.overflow) continue;
    if (f.overflow && f.axes == 2) continue;
    const bool binary_fits = allows(known.big_endian, f.big_endian) && allows(known.records, f.records) &&
                             allows(known.bits, f.bits);
    if (!allows(known.ascii, f.ascii) || !allows(known.multi_block, f.multi_block)) continue;
    if ((!f.ascii && !binary_fits) || (!solution && !allows(known.iblank, f.iblank))) continue;
    all.push_back(f);
  }
  return all;
}

std::string size_text(const Dims& d) {
  return std::to_string(d[0]) + " x " + std::to_string(d[1]) + " x " + std::to_string(d[2]);
}

}  // namespace

std::string Plot3dForm::text() const {
  std::string t = ascii ? "ascii"
                        : std::string(big_endian ? "big" : "little") + "," +
                              (records ? "records" : "stream") + "," + (bits == 32 ? "f32" : "f64");
  t += multi_block ? ",multi" : ",single";
  if (overflow) t += " (OVERFLOW)";
  return t + (iblank ? ",iblank" : "") + (axes == 2 ? " (2-D)" : "");
}

Plot3dNumbers::Plot3dNumbers(std::string name, std::vector<std::byte> bytes)
    : name_(std::move(name)), bytes_(std::move(bytes)), ascii_(looks_like_text(bytes_)) {
  if (ascii_) scan();
}

void Plot3dNumbers::scan() {
  const std::string_view text(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
  const auto separates = [](char c) { return c == ' ' || c == ',' || c == '\n' || c == '\r' || c == '\t'; };
  const auto most = kMostNumbersPerByte * static_cast<std::int64_t>(text.size());
  std::size_t at = 0;
  while (at < text.size()) {
    if (separates(text[at])) {
      ++at;
      continue;
    }
    std::size_t end = at;
    while (end < text.size() && !separates(text[end])) ++end;
    std::string word(text.substr(at, end - at));
    at = end;
    std::int64_t repeat = 1;
    if (const std::size_t star = word.find('*'); star != std::string::npos) {
      repeat = parse_integer({name_, "repeat count"}, word.substr(0, star));
      word.erase(0, star + 1);
    }
    for (char& c : word) {
      if (c == 'd' || c == 'D') c = 'e';  // Fortran's exponent of double precision
    }
    double value = 0;
    try {
      value = parse_number({name_, "number"}, word);
    } catch (const Error&) {
      if (!numbers_.empty()) throw;  // else it is some other text
      throw Error(
          name_ +
          ": neither a VTK XML structured grid (.vts) nor PLOT3D, whose text begins with a number, not " +
          in_quotes(word));
    }
    if (repeat < 1 || repeat > most - static_cast<std::int64_t>(numbers_.size())) {
      throw Error(name_ + ": repeat count " + std::to_string(repeat) + " is out of range");
    }
    numbers_.insert(numbers_.end(), static_cast<std::size_t>(repeat), value);
  }
  bytes_.clear();
  bytes_.shrink_to_fit();
}

std::int64_t Plot3dNumbers::size() const {
  return static_cast<std::int64_t>(ascii_ ? numbers_.size() : bytes_.size());
}

std::int64_t Plot3dNumbers::integer(std::int64_t at, const Plot3dForm& form) const {
  if (ascii_) {
    const double x = numbers_[static_cast<std::size_t>(at)];
    const bool whole = x >= -1e9 && x <= 1e9 && x == static_cast<double>(static_cast<std::int64_t>(x));
    return whole ? static_cast<std::int64_t>(x) : std::numeric_limits<std::int32_t>::min();
  }
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value = value << 8 |
            static_cast<std::uint32_t>(bytes_[static_cast<std::size_t>(at) + (form.big_endian ? i : 3 - i)]);
  }
  return static_cast<std::int32_t>(value);
}

double Plot3dNumbers::real(std::int64_t at, const Plot3dForm& form) const {
  if (ascii_) return numbers_[static_cast<std::size_t>(at)];
  std::uint64_t value = 0;
  const auto n = static_cast<std::size_t>(form.bits / 8);
  for (std::size_t i = 0; i < n; ++i) {
    value = value << 8 | static_cast<std::uint64_t>(
                             bytes_[static_cast<std::size_t>(at) + (form.big_endian ? i : n - 1 - i)]);
  }
  if (n == 8) return std::bit_cast<double>(value);
  return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(value)));
}

bool Plot3dNumbers::zero_from(std::int64_t at) const {
  if (ascii_) return std::all_of(numbers_.begin() + at, numbers_.end(), [](double x) { return x == 0; });
  return std::all_of(bytes_.begin() + at, bytes_.end(), [](std::byte b) { return b == std::byte{0}; });
}

Plot3dFit fit_plot3d(const Plot3dNumbers& numbers, const Plot3dLayout& known,
                     const std::vector<Dims>& expected) {
  const bool solution = !expected.empty();
  const auto tried = forms(numbers, known, solution);
  std::vector<Plot3dFit> fits;
  std::string other_sizes;
  for (const auto& form : tried) {
    auto fit = Walk(numbers, form).fit(solution);
    if (!fit) continue;
    if (solution && fit->dims != expected) {
      other_sizes = std::to_string(fit->dims.size()) + " blocks, the first " + size_text(fit->dims[0]);
      continue;
    }
    fits.push_back(std::move(*fit));
  }
  // Those that use the file up before those that leave something over; 3-D before 2-D.
  const auto rank = [](const Plot3dFit& f) { return (f.left_over > 0 ? 2 : 0) + (f.form.axes == 2 ? 1 : 0); };
  int best = 4;
  for (const auto& fit : fits) best = std::min(best, rank(fit));
  std::erase_if(fits, [&](const Plot3dFit& fit) { return rank(fit) != best; });
  if (fits.empty() && !other_sizes.empty()) {
    throw Error(numbers.name() + ": solution of " + other_sizes + ", but the grid has " +
                std::to_string(expected.size()) + " blocks, the first " + size_text(expected[0]));
  }
  if (fits.empty()) {
    throw Error(numbers.name() + ": no PLOT3D layout fits its " + std::to_string(numbers.size()) +
                (numbers.ascii() ? " numbers" : " bytes") + "; tried " + std::to_string(tried.size()) + ": " +
                (numbers.ascii() ? "text" : "little and big endian, records and stream, f32 and f64") +
                ", single and multi-block" + (solution ? "" : ", with and without IBLANK") + ", 3-D and 2-D" +
                ", as --plot3d allows");
  }
  if (fits[0].form.axes == 2) {
    throw Error(numbers.name() + ": a 2-D grid (" + fits[0].form.text() + "), which encloses no volume");
  }
  if (fits.size() > 1) {
    std::string list;
    for (const auto& fit : fits) list += (list.empty() ? "" : "; ") + fit.form.text();
    throw Error(numbers.name() + ": several PLOT3D layouts fit: " + list + "; say which by --plot3d");
  }
  return fits[0];
}

Plot3dLayout Plot3dLayout::parse(const std::string& text) {
  Plot3dLayout layout;
  if (text == "auto") return layout;
  std::size_t at = 0;
  while (at <= text.size()) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string word = text.substr(at, end - at);
    at = end + 1;
    if (word == "ascii") {
      layout.ascii = true;
    } else if (word == "big" || word == "little") {
      layout.ascii = false;
      layout.big_endian = word == "big";
    } else if (word == "records" || word == "stream") {
      layout.ascii = false;
      layout.records = word == "records";
    } else if (word == "single" || word == "multi") {
      layout.multi_block = word == "multi";
    } else if (word == "f32" || word == "f64") {
      layout.ascii = false;
      layout.bits = word == "f32" ? 32 : 64;
    } else if (word == "iblank" || word == "plain") {
      layout.iblank = word == "iblank";
    } else {
      throw Error(
          "--plot3d " + in_quotes(text) +
          ": expected auto, or words of ascii, big, little, records, stream, single, multi, f32, f64, "
          "iblank, plain, joined by commas");
    }
  }
  return layout;
}

}  // namespace vol::io
