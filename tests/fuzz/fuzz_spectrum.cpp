#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/error.h"
#include "io/spectrum.h"

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
      const auto spectrum = file.read_spectrum<double>();
      if (spectrum.fields.size() != file.info().names.size()) std::abort();
    } else {
      const auto source = file.read_slice_source<float>(4);
      if (source.fields() != file.info().names.size()) std::abort();
    }
  } catch (const vol::Error& e) {
    const std::string message = e.what();
    if (message.empty() || message.find('\n') != std::string::npos) std::abort();
  }
  return 0;
}
