// make_spectrum_seeds FOLDER: small spectra for the fuzzer to start from, in FOLDER/spectrum.
#include <filesystem>

#include "io/spectrum.h"

namespace {

template <class T>
void write(const std::filesystem::path& path, std::vector<std::string> names) {
  vol::fourier::SpectrumInfo info;
  info.geometry.dims = {3, 2, 1};
  info.padded = {4, 3, 2};
  info.padding = 1.25;
  info.compensation = "es:4";
  info.model = names.size() == 4 ? "depth-cue" : "plain";
  info.names = std::move(names);
  vol::fourier::Spectrum<T> spectrum;
  spectrum.info = info;
  for (std::size_t f = 0; f < info.names.size(); ++f) {
    spectrum.fields.emplace_back(static_cast<std::size_t>(2 * info.count()), T(1));
  }
  vol::io::write_spectrum(path, spectrum, {{"precis.tool", "vol-fft"}});
}

}  // namespace

int main(int, char** argv) {
  const std::filesystem::path folder = std::filesystem::path(argv[1]) / "spectrum";
  std::filesystem::create_directories(folder);
  write<float>(folder / "one.nrrd", {"f"});
  write<double>(folder / "four.nrrd", {"f", "f Dx", "f Dy", "f Dz"});
}
