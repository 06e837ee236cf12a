#include "fuzz_file.h"
#include "io/label_looks.h"
#include "io/scene.h"
#include "transfer/bezier.h"

// The same bytes as each of the small text files: transfer function, Bezier curves, labels' looks, preset,
// profile.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const vol::io::FuzzFile file;
  file.fill(data, size);
  using vol::io::fuzz_read;
  const auto yaml = file.named(".yaml"), json = file.named(".json"), csv = file.named(".csv");
  const auto asked = [](const vol::transfer::TransferFunction& f) {
    for (const double v : {-1.7e308, -1e300, 0.0, 0.3, 1e300, 1.7e308}) {
      const double opacity = f.opacity(v);
      if (!(opacity >= 0 && opacity <= 1) || !(f.colour(v).minCoeff() >= 0)) std::abort();
    }
  };
  fuzz_read([&] { asked(vol::io::read_transfer_function(yaml)); });
  fuzz_read([&] { asked(vol::io::read_transfer_function(json)); });
  fuzz_read([&] {
    if (const auto bezier = vol::io::read_bezier(yaml)) bezier->validate();
  });
  fuzz_read([&] {
    for (const auto& look : vol::io::read_label_looks(yaml)) {
      if (!(look.opacity >= 0 && look.opacity <= 1) || !(look.colour.minCoeff() >= 0)) std::abort();
    }
  });
  fuzz_read([&] { (void)vol::io::read_profile(csv); });
  return 0;
}
