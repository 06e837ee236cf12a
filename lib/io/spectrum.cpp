#include "io/spectrum.h"

#include <algorithm>
#include <bit>
#include <sstream>

#include "base/checked.h"
#include "base/error.h"
#include "io/header_text.h"
#include "io/nrrd_header.h"
#include "io/volume.h"

namespace vol::io {
namespace {

const std::string kPrefix = "precis.spectrum.";

std::string three(const Dims& d) {
  return std::to_string(d[0]) + " " + std::to_string(d[1]) + " " + std::to_string(d[2]);
}

std::map<std::string, std::string> keys_of(const fourier::SpectrumInfo& info) {
  const volume::GridGeometry& g = info.geometry;
  std::string direction, names;
  for (int c = 0; c < 3; ++c) direction += (c > 0 ? " " : "") + shortest(Vec3(g.direction.col(c)));
  for (const auto& name : info.names) names += (names.empty() ? "" : "\n") + name;
  return {{kPrefix + "dims", three(g.dims)},
          {kPrefix + "spacing", shortest(g.spacing)},
          {kPrefix + "origin", shortest(g.origin)},
          {kPrefix + "direction", direction},
          {kPrefix + "space", std::string(volume::name(g.space))},
          {kPrefix + "padded", three(info.padded)},
          {kPrefix + "padding", shortest(info.padding)},
          {kPrefix + "compensation", info.compensation},
          {kPrefix + "model", info.model},
          {kPrefix + "names", names}};
}

/// Takes the spectrum's own keys out of a file's attributes.
class Keys {
 public:
  explicit Keys(nrrd::Header& header) : header_(header) {}
  std::string text(const std::string& name) const {
    const auto found = header_.attributes.find(kPrefix + name);
    if (found == header_.attributes.end())
      throw Error(header_.name + ": spectrum without the key " + kPrefix + name);
    return found->second;
  }
  Dims dims(const std::string& name) const {
    const auto v = parse_integers(Field{header_.name, kPrefix + name}, text(name), 3);
    return {v[0], v[1], v[2]};
  }
  std::vector<double> numbers(const std::string& name, std::size_t n) const {
    return parse_numbers(Field{header_.name, kPrefix + name}, text(name), n);
  }

 private:
  nrrd::Header& header_;
};

fourier::SpectrumInfo info_of(nrrd::Header& header) {
  const auto kind = header.attributes.find(kKindKey);
  if (kind == header.attributes.end() || kind->second != "spectrum") {
    throw Error(header.name + ": is not a spectrum; make one with vol-fft");
  }
  const Keys keys(header);
  fourier::SpectrumInfo info;
  volume::GridGeometry& g = info.geometry;
  g.dims = keys.dims("dims");
  const auto spacing = keys.numbers("spacing", 3), origin = keys.numbers("origin", 3),
             direction = keys.numbers("direction", 9);
  g.spacing = Vec3(spacing[0], spacing[1], spacing[2]);
  g.origin = Vec3(origin[0], origin[1], origin[2]);
  for (int c = 0; c < 3; ++c)
    g.direction.col(c) = Vec3(direction[3 * c], direction[3 * c + 1], direction[3 * c + 2]);
  const std::string space = keys.text("space");
  bool known = false;
  for (const auto s : {volume::Space::none, volume::Space::lps, volume::Space::ras}) {
    if (space != volume::name(s)) continue;
    g.space = s;
    known = true;
  }
  if (!known) throw Error(header.name + ": the spectrum's space is none of those known; none, LPS or RAS");
  info.padded = keys.dims("padded");
  info.padding = keys.numbers("padding", 1)[0];
  info.compensation = keys.text("compensation");
  info.model = keys.text("model");
  info.names.clear();
  std::istringstream lines(keys.text("names"));
  for (std::string line; std::getline(lines, line);) info.names.push_back(line);
  try {
    info.validate();
  } catch (const Error& error) {
    throw Error(header.name, error);
  }
  for (const auto& [key, value] : header.attributes) {
    if (key != kKindKey && !key.starts_with(kPrefix)) info.attributes[key] = value;
  }
  return info;
}

/// \throws vol::Error naming the file
template <class T>
void require_finite(const T* values, std::int64_t count, const std::string& file) {
  T poison = 0;  // stays 0 unless something is not finite
  for (std::int64_t i = 0; i < count; ++i) poison += values[i] * 0;
  if (!(poison == 0)) throw Error(file + ": the spectrum holds a number that is not finite");
}

}  // namespace

template <class T>
void write_spectrum(const std::filesystem::path& path, const fourier::Spectrum<T>& spectrum,
                    const std::map<std::string, std::string>& attributes) {
  static_assert(std::endian::native == std::endian::little);
  const fourier::SpectrumInfo& info = spectrum.info;
  const bool several = info.names.size() > 1;
  std::string header = std::string("NRRD0005\ntype: ") + (sizeof(T) == 8 ? "double" : "float") +
                       "\ndimension: " + (several ? "5" : "4") + "\nsizes: 2 " +
                       std::to_string(info.row_length()) + " " + std::to_string(info.padded[1]) + " " +
                       std::to_string(info.padded[2]);
  if (several) header += " " + std::to_string(info.names.size());
  header += std::string("\nkinds: complex domain domain domain") + (several ? " list" : "") +
            "\nendian: little\nencoding: raw\n" + kKindKey + ":=spectrum\n";  // early, for is_spectrum()
  auto all = info.attributes;
  for (const auto& [key, value] : attributes) all[key] = value;
  for (const auto& [key, value] : keys_of(info)) all[key] = value;
  for (const auto& [key, value] : all) {
    // A volume's attribute that the syntax cannot hold is no loss to its spectrum.
    if (key == kKindKey || key.empty() || key[0] == '#' || key.find(':') != std::string::npos ||
        value.find('\r') != std::string::npos)
      continue;
    header += nrrd::escaped(key) + ":=" + nrrd::escaped(value) + "\n";
  }
  OutputFile out(path);
  out.write(header + "\n");
  for (const auto& field : spectrum.fields) out.write(field.data(), field.size() * sizeof(T));
  out.commit();
}

bool is_spectrum(InputFile& file) {
  const std::string_view begin = file.peek(4096);
  if (!begin.starts_with("NRRD")) return false;
  const std::string_view header = begin.substr(0, std::min(begin.find("\n\n"), begin.find("\n\r\n")));
  const std::string line = std::string("\n") + kKindKey + ":=spectrum";
  const std::size_t at = header.find(line);
  if (at == header.npos) return false;
  const std::size_t end = at + line.size();
  return end == header.size() || header[end] == '\n' || header[end] == '\r';
}

SpectrumHeader read_spectrum_header(InputFile& file) {
  if (!file.peek(4).starts_with("NRRD"))
    throw Error(display_name(file.path()) + ": is not a spectrum; make one with vol-fft");
  nrrd::Header header = nrrd::read_header(file);
  const fourier::SpectrumInfo info = info_of(header);
  const auto type = nrrd::voxel_type(header);
  const bool is_double = type == volume::VoxelType::f64;
  if (!volume::is_floating_point(type))
    throw Error(header.name + ": spectrum of a type other than float and double");
  std::vector<std::int64_t> expected{2, info.row_length(), info.padded[1], info.padded[2]};
  const auto fields = static_cast<std::int64_t>(info.names.size());
  if (fields > 1) expected.push_back(fields);
  const std::string& dimension = header.need("dimension");
  if (parse_integer(header.field("dimension"), dimension) != static_cast<std::int64_t>(expected.size()) ||
      parse_integers(header.field("sizes"), header.need("sizes"), expected.size()) != expected) {
    throw Error(header.name + ": sizes " + header.need("sizes") +
                " are not those of the spectrum that its keys describe");
  }
  if (lower_case(header.need("encoding")) != "raw" || lower_case(header.need("endian")) != "little" ||
      header.find("datafile") != nullptr) {
    throw Error(header.name + ": a spectrum is raw, little-endian and in one file, as vol-fft writes it");
  }
  file.require(checked_product(checked_product(info.count(), fields), is_double ? 16 : 8));
  return {info, is_double};
}

SpectrumFile::SpectrumFile(const std::filesystem::path& path)
    : file_(path), header_(read_spectrum_header(file_)) {}

template <class T>
fourier::SliceSource<T> SpectrumFile::read_slice_source(int taps) {
  fourier::SliceSource<T> source(header_.info, taps);
  const Dims& m = header_.info.padded;
  const std::size_t bytes = static_cast<std::size_t>(2 * header_.info.row_length()) * sizeof(T);
  for (std::size_t f = 0; f < header_.info.names.size(); ++f) {
    for (std::int64_t k = 0; k < m[2]; ++k) {
      for (std::int64_t j = 0; j < m[1]; ++j) {
        T* row = source.row(f, j - m[1] / 2, k - m[2] / 2);
        file_.read_exactly(row, bytes);
        require_finite(row, 2 * header_.info.row_length(), display_name(file_.path()));
      }
    }
  }
  source.fill_margins();
  return source;
}

template <class T>
fourier::Spectrum<T> SpectrumFile::read_spectrum() {
  fourier::Spectrum<T> spectrum{header_.info, {}};
  for (std::size_t f = 0; f < header_.info.names.size(); ++f) {
    auto& field = spectrum.fields.emplace_back(static_cast<std::size_t>(2 * header_.info.count()));
    file_.read_exactly(field.data(), field.size() * sizeof(T));
    require_finite(field.data(), static_cast<std::int64_t>(field.size()), display_name(file_.path()));
  }
  return spectrum;
}

template void write_spectrum(const std::filesystem::path&, const fourier::Spectrum<float>&,
                             const std::map<std::string, std::string>&);
template void write_spectrum(const std::filesystem::path&, const fourier::Spectrum<double>&,
                             const std::map<std::string, std::string>&);
template fourier::SliceSource<float> SpectrumFile::read_slice_source(int);
template fourier::SliceSource<double> SpectrumFile::read_slice_source(int);
template fourier::Spectrum<float> SpectrumFile::read_spectrum();
template fourier::Spectrum<double> SpectrumFile::read_spectrum();

}  // namespace vol::io
