// homogeneous_sheets: a homogeneous medium in every phantom grid by sheets, against the lengths of the rays
// inside, as a table (CSV): relative errors of optical depth over the pixels whose chord exceeds a tenth of the
// longest. By layers, opacity follows no length: the extinction is that which fits best, and what is left is
// the glow.
#include <cstdio>
#include <cstdlib>

#include "../curvilinear/homogeneous.h"

using namespace vol;
using namespace vol::curvilinear;

int main(int argc, char** argv) {
  const int size = argc > 1 ? std::atoi(argv[1]) : 512;
  std::puts("grid,thickness,throttle,pixels,rms,largest,mean");
  for (const PhantomName& phantom : phantom_names()) {
    camera::View view;
    view.azimuth = 33;
    view.elevation = 21;
    const Homogeneous medium(phantom.name.data(), phantom.dims, view, size);
    const auto row = [&](Thickness thickness, double throttle) {
      const bool layers = thickness == Thickness::layers;
      const ChordErrors e = chord_errors(medium, medium.draw(thickness, throttle).image,
                                         layers ? 0 : 1 / medium.reference_length());
      std::printf("%s,%s,%g,%d,%.5f,%.4f,%.5f\n", phantom.name.data(), layers ? "layers" : "physical", throttle,
                  e.pixels, e.rms, e.largest, e.mean);
    };
    for (const double throttle : {1.0, 2.0, 4.0}) row(Thickness::physical, throttle);
    row(Thickness::layers, 1);
  }
}
