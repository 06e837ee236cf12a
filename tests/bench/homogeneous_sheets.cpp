// homogeneous_sheets: a homogeneous medium in every phantom grid by sheets, 512 x 512 pixels, against the
// lengths of rays inside, as a table (CSV): relative errors of optical depth over the pixels whose chord
// exceeds a tenth of the longest. By layers, what is left under the extinction that fits best: the glow.
#include <cstdio>

#include "../curvilinear/homogeneous.h"

using namespace vol;
using namespace vol::curvilinear;

int main() {
  std::puts("grid,sheets,throttle,pixels,rms,largest,mean");
  for (const PhantomName& phantom : phantom_names()) {
    camera::View view;
    view.azimuth = 33;
    view.elevation = 21;
    const Homogeneous medium(phantom.name, phantom.dims, view, 512);
    const auto row = [&](Thickness thickness, double throttle) {
      const ChordErrors e = medium.errors(medium.draw(thickness, throttle).image, thickness);
      std::printf("%s,%s,%g,%d,%.2g,%.2g,%.2g\n", phantom.name.data(),
                  thickness == Thickness::layers ? "layers" : "physical", throttle, e.pixels, e.rms,
                  e.largest, e.mean);
    };
    for (const double throttle : {1.0, 4.0, 16.0}) row(Thickness::physical, throttle);
    row(Thickness::layers, 1);
  }
}
