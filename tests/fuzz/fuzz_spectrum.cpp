#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/error.h"
#include "fourier/projection.h"
#include "io/spectrum.h"

namespace {

/// One oblique view, small, with the slice wide enough for the volume and at the picture's own frequencies.
template <class T>
void draw(vol::io::SpectrumFile& file) {
  const vol::fourier::Filter filter("catmull-rom", 1);
  const auto source = file.read_slice_source<T>(filter.taps());
  if (source.fields() != file.info().names.size()) std::abort();
  const auto& g = file.info().geometry;
  for (const bool wrap : {true, false}) {
    for (const double share : {1.6, 1e-12}) {
      vol::camera::View at;
      at.azimuth = 33;
      at.width = share * g.edge_lengths().maxCoeff();
      try {
        const vol::camera::Camera camera(at, g.centre(), g.edge_lengths().maxCoeff(), 8, 6);
        const auto view = vol::fourier::slice_view(file.info(), camera, 8, 6, wrap);
        if (view.width * view.height > 4096) continue;
        vol::fourier::Projector<T> projector(source, filter, true);
        const vol::fourier::ChannelWeights weights{std::vector<double>(source.fields(), 1.0)};
        if (projector.project(view, weights)[0].size() != 48) std::abort();
      } catch (const vol::Error&) {  // impossible sizes
      }
    }
  }
}

}  // namespace

// A spectrum file may be refused with one line, by vol::Error and nothing else; what is read must fit its
// header.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const int memory = ::memfd_create("fuzz", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(memory);
  if (::ftruncate(memory, 0) != 0 || ::pwrite(memory, data, size, 0) != static_cast<ssize_t>(size))
    std::abort();
  try {
    vol::io::SpectrumFile file(path);  // refuses data shorter than promised, so what follows is small
    if (file.is_double()) {
      draw<double>(file);
    } else {
      draw<float>(file);
    }
    vol::io::SpectrumFile again(path);
    if (again.is_double()) {
      auto spectrum = again.read_spectrum<double>();
      if (spectrum.fields.size() != again.info().names.size()) std::abort();
    }
  } catch (const vol::Error& e) {
    const std::string message = e.what();
    if (message.empty() || message.find('\n') != std::string::npos) std::abort();
  }
  return 0;
}
