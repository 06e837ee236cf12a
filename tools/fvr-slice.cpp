// fvr-slice: Fourier volume rendering on the CPU: pictures of a spectrum by the projection-slice theorem.
//   vol-fft head.nrrd -o spectrum.nrrd --compensate es:6 && fvr-slice spectrum.nrrd -o head.exr --view 30,20
//   fvr-slice spectrum.nrrd -o turn.png --turntable 36 --size 256x256 --stats turn.json
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/timer.h"
#include "cli/fvr.h"
#include "cli/naming.h"
#include "cli/run.h"
#include "fourier/projection.h"
#include "io/spectrum.h"
#include "io/volume.h"

namespace {

using namespace vol;

struct Options {
  cli::FvrOptions fvr;
  std::string algorithm = "fast";
};

template <class T>
void draw(io::SpectrumFile& file, const fourier::Filter& filter, const std::vector<cli::FvrView>& views,
          const Options& o, cli::Record& record) {
  cli::fvr_require_memory(o.fvr, file.info(), views,
                          fourier::SliceSource<T>::bytes(file.info(), filter.taps()), sizeof(T), record);
  const auto source = record.timed("read", [&] { return file.read_slice_source<T>(filter.taps()); });
  fourier::Projector<T> projector(source, filter, o.algorithm == "plain");
  double seconds = 0;
  std::int64_t frames = 0;
  cli::fvr_pictures(
      o.fvr, file.info(), views,
      [&](const fourier::SliceView& view, const fourier::ChannelWeights& weights,
          std::vector<Buffer<float>>& picture) {
        const Timer timer;
        if constexpr (std::is_same_v<T, float>) {
          projector.project(view, weights, picture);
        } else {
          picture.clear();
          for (const auto& plane : projector.project(view, weights)) {
            auto& narrow = picture.emplace_back(plane.size());
            for (std::size_t i = 0; i < plane.size(); ++i) narrow[i] = static_cast<float>(plane[i]);
          }
        }
        seconds += timer.seconds();
        ++frames;
      },
      record);
  const double n = static_cast<double>(frames);
  record.count("points", projector.points());
  record.result("frames_per_second", n / seconds);
  record.result("slice_s_per_frame", projector.times().slice / n);
  record.result("inverse_s_per_frame", projector.times().inverse / n);
}

int work(const Options& o, cli::Record& record) {
  const auto views = cli::fvr_views(o.fvr, record);  // wrong words are answered before a large file is read
  record.input(o.fvr.input);
  io::SpectrumFile file(o.fvr.input);
  cli::naming(o.fvr.input, [&] {
    const fourier::Filter filter = cli::fvr_filter(o.fvr, file.info(), record);
    if (file.is_double()) {
      draw<double>(file, filter, views, o, record);
    } else {
      draw<float>(file, filter, views, o, record);
    }
  });
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Fourier volume rendering: orthographic X-ray pictures of a spectrum by the projection-slice theorem.\n"
      "A pixel is the sum over samples times world length, to overlay vol-raycast --model xray."};
  Options options;
  cli::add_fvr_options(app, options.fvr);
  app.add_option("--algorithm", options.algorithm,
                 "fast (SIMD, for f32 spectra) or plain (double, its oracle)")
      ->check(CLI::IsMember({"fast", "plain"}))
      ->capture_default_str()
      ->group("Accuracy against cost");
  return cli::run(
      app,
      {.name = "fvr-slice",
       .example =
           "vol-phantom gaussians -o - | vol-fft - --compensate es:6 -o - | fvr-slice - -o picture.exr "
           "--view 30,20",
       .references = "Totsuka & Levoy 1993; Cheng 2007; Barnett, Magland & af Klinteberg 2019",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
