// fvr-slice-gpu: fvr-slice on a GPU, without a display, by EGL and OpenGL 4.5.
//   fvr-slice-gpu spectrum.nrrd -o turn.png --turntable 36 --size 256x256 --ifft gpu
#include <nlohmann/json.hpp>

#include "base/checked.h"
#include "base/error.h"
#include "base/timer.h"
#include "cli/fvr.h"
#include "cli/naming.h"
#include "cli/run.h"
#include "fourier_gpu/gpu_projector.h"
#include "io/spectrum.h"
#include "io/volume.h"

namespace {

using namespace vol;

struct Options {
  cli::FvrOptions fvr;
  std::string ifft = "fftw";
};

int draw(io::SpectrumFile& file, const std::vector<cli::FvrView>& views, const Options& o,
         cli::Record& record) {
  const fourier::Filter filter = cli::fvr_filter(o.fvr, file.info(), record);
  if (file.is_double()) throw Error("fvr-slice-gpu takes f32 spectra; draw this one with fvr-slice");
  const gpu::Context context;
  record.device(context.device());
  // On a software renderer the device's copy of the spectrum is in this memory too.
  cli::fvr_require_memory(o.fvr, file.info(), views,
                          checked_product(2, fourier::SliceSource<float>::bytes(file.info(), filter.taps())),
                          4 * sizeof(float), record);
  const auto source = record.timed("read", [&] { return file.read_slice_source<float>(filter.taps()); });
  const auto by = o.ifft == "gpu" ? fourier_gpu::InverseBy::gpu : fourier_gpu::InverseBy::fftw;
  std::optional<fourier_gpu::GpuProjector> projector;
  record.timed("upload", [&] {
    projector.emplace(context, source, filter, by);
    gpu::finish();
  });
  double seconds = 0, frames = 0;
  cli::fvr_pictures(
      o.fvr, file.info(), views,
      [&](const fourier::SliceView& view, const fourier::ChannelWeights& weights,
          std::vector<Buffer<float>>& picture) {
        const Timer timer;
        picture = projector->project(view, weights);
        seconds += timer.seconds();
        ++frames;
      },
      record);
  record.result("frames_per_second", frames / seconds);
  record.result("slice_s_per_frame", projector->times().slice / frames);
  record.result("inverse_s_per_frame", projector->times().inverse / frames);
  record.result("read_back_s_per_frame", projector->times().read_back / frames);
  return 0;
}

int work(const Options& o, cli::Record& record) {
  const auto views = cli::fvr_views(o.fvr, record);  // wrong words are answered before a large file is read
  record.input(o.fvr.input);
  io::SpectrumFile file(o.fvr.input);
  return cli::naming(o.fvr.input, [&] { return draw(file, views, o, record); });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Fourier volume rendering on a GPU, without a display: the options and pictures of fvr-slice.\n"
      "Needs EGL and OpenGL 4.5 (Mesa's software renderer will do); where there is none it ends with status "
      "3."};
  Options options;
  cli::add_fvr_options(app, options.fvr);
  app.add_option("--ifft", options.ifft,
                 "Transform back by fftw, or on the gpu: sizes of factors 2, 3, 5 and 7")
      ->check(CLI::IsMember({"fftw", "gpu"}))
      ->capture_default_str()
      ->group("Accuracy against cost");
  return cli::run(
      app,
      {.name = "fvr-slice-gpu",
       .example =
           "vol-phantom gaussians -o - | vol-fft - --compensate es:6 -o - | fvr-slice-gpu - -o picture.exr "
           "--view 30,20",
       .references = "Cheng 2007; Jansen et al. 2004",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return work(options, record); });
}
