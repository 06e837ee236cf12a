// img-compare: error of one image against another.
//   img-compare picture.exr truth.exr
//   img-compare picture.exr truth.exr --json --fail-above rmse_byte=0.5 --difference difference.png
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/image_report.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/threshold.h"
#include "image/difference.h"
#include "image/metrics.h"
#include "io/file.h"
#include "io/image.h"
#include "io/write_image.h"

namespace {

using namespace vol;
using image::ChannelPair;
using image::Image;

struct Options {
  std::string tested, reference, difference, background, peak = "1";
  std::vector<std::string> channels, metrics;
  cli::ThresholdOptions thresholds;
  bool json = false, raw_values = false, is_signed = false;
  double difference_scale = 0;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("image", o.tested, "The image under test; - for standard input")->required()->group("Files");
  app.add_option("reference", o.reference, "The truth it is held against; same size")
      ->required()
      ->group("Files");
  app.add_option("--difference", o.difference,
                 "Write the difference picture: .exr (each channel as it is) or .png (false colours of the "
                 "channel that differs most)")
      ->type_name("FILE")
      ->group("Files");
  app.add_option(
         "--channel", o.channels,
         "Compare this channel as it stands instead of the colour (samples, depth, error, A ...); repeatable")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->group("What is compared");
  app.add_option("--background", o.background,
                 "Linear R,G,B, or one number, under what is transparent; default: what both images say they "
                 "were rendered over, else 0")
      ->type_name("R,G,B")
      ->group("What is compared");
  app.add_flag("--raw-values", o.raw_values,
               "Take the codes of integer files (PNG, TIFF, JPEG) as linear; without it they are sRGB and "
               "converted")
      ->group("What is compared");
  app.add_option("--peak", o.peak,
                 "Largest signal, for PSNR, SSIM and the byte scale (255/peak): a number, or truth for the "
                 "reference's maximum (x-ray)")
      ->type_name("VALUE")
      ->capture_default_str()
      ->group("Figures");
  app.add_option("--metric", o.metrics,
                 "Only these, comma-separated: mse, rmse, mse_byte, rmse_byte, mae, max, psnr, ssim, nan, "
                 "infinite (the last two count values)")
      ->type_name("NAME")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(cli::image_metric_names()))
      ->group("Figures");
  app.add_flag("--json", o.json,
               "JSON instead of a table; what is infinite or undefined stands as \"inf\", \"-inf\", \"nan\"")
      ->group("Figures");
  app.add_flag("--signed", o.is_signed, "Difference picture of image - reference, not of its magnitude")
      ->group("Figures");
  app.add_option("--difference-scale", o.difference_scale,
                 "Difference shown in the last colour of a .png; default: the largest")
      ->type_name("VALUE")
      ->check(cli::check_positive)
      ->group("Figures");
  app.add_option("--fail-above", o.thresholds.above,
                 "Exit with 1 unless METRIC of all channels is at most VALUE; repeatable")
      ->type_name("METRIC=VALUE")
      ->allow_extra_args(false)
      ->group("Pass or fail");
  app.add_option("--fail-below", o.thresholds.below,
                 "Exit with 1 unless METRIC (psnr, ssim) is at least VALUE; repeatable")
      ->type_name("METRIC=VALUE")
      ->allow_extra_args(false)
      ->group("Pass or fail");
}

std::array<double, 3> background(const Options& options, const Image& tested, const Image& reference) {
  std::string text = options.background;
  std::string source = "--background";
  if (text.empty()) {
    const auto a = tested.attributes.find("precis.background");
    const auto b = reference.attributes.find("precis.background");
    if (a == tested.attributes.end() || b == reference.attributes.end()) return {0, 0, 0};
    if (a->second != b->second) {
      throw Error("the images were rendered over different backgrounds, " + a->second + " and " + b->second +
                  "; give --background");
    }
    text = a->second;
    source = "precis.background";
  }
  std::erase_if(text, [](char c) { return c == '[' || c == ']' || c == ' '; });
  const Vec3 rgb = cli::parse_vec3(source, text);
  return {rgb[0], rgb[1], rgb[2]};
}

/// Colour against colour, grey standing for three equal channels, or the named channels as they are.
std::vector<ChannelPair> channel_pairs(const Options& options, const Image& tested, const Image& reference) {
  std::vector<ChannelPair> pairs;
  for (const auto& name : options.channels) {
    const auto t = tested.channel(name);
    const auto r = reference.channel(name);
    if (!t) throw Error(options.tested + ": has no channel " + name);
    if (!r) throw Error(options.reference + ": has no channel " + name);
    pairs.push_back({name, *t, *r});
  }
  if (!pairs.empty()) return pairs;
  const auto colour = [](const std::string& path, const Image& picture) {
    try {
      return image::colour_channels(picture);
    } catch (const Error& cause) {
      throw Error(io::display_name(path), Error(std::string(cause.what()) + "; name one with --channel"));
    }
  };
  const auto t = colour(options.tested, tested);
  const auto r = colour(options.reference, reference);
  if (t[0] == t[1] && r[0] == r[1]) return {{"Y", t[0], r[0]}};
  return {{"R", t[0], r[0]}, {"G", t[1], r[1]}, {"B", t[2], r[2]}};
}

double peak(const Options& options, const Image& reference, const std::vector<ChannelPair>& pairs) {
  double value = 0;
  if (options.peak == "truth") {
    std::vector<int> channels;
    for (const auto& pair : pairs) channels.push_back(pair.reference);
    value = image::largest_value(reference, channels);
    if (!(value > 0)) throw Error(options.reference + ": has no positive value to take as --peak truth");
    return value;
  }
  char* end = nullptr;
  value = std::strtod(options.peak.c_str(), &end);
  if (end == options.peak.c_str() || *end != '\0' || !(value > 0) || !std::isfinite(value)) {
    throw Error("--peak " + options.peak + ": expected a positive number or truth");
  }
  return value;
}

void write_difference(const Options& options, const Image& tested, const Image& reference,
                      const std::vector<ChannelPair>& pairs, cli::Record& record) {
  using image::DifferenceKind;
  const auto kind = options.is_signed ? DifferenceKind::signed_ : DifferenceKind::absolute;
  Image picture = image::difference(tested, reference, pairs, kind);
  auto attributes = record.provenance();
  std::string key;  // to the colours
  if (std::filesystem::path(options.difference).extension() == ".png") {
    const double largest = image::largest_magnitude(picture);
    const double scale = options.difference_scale > 0 ? options.difference_scale : largest > 0 ? largest : 1;
    picture = image::false_colour(picture, scale, kind);
    const std::string text = cli::figure_text(scale);
    attributes["precis.difference_scale"] = text;
    key = options.is_signed ? "difference: blue -" + text + ", white 0, red " + text
                            : "difference: black 0, light yellow " + text;
  }
  picture.attributes = std::move(attributes);
  record.timed("write", [&] { io::write_image(options.difference, picture); });
  record.output(options.difference);
  if (!key.empty()) record.say(key);
}

int compare_images(const Options& options, cli::Record& record) {
  const cli::Thresholds thresholds(options.thresholds, cli::image_metric_names(true),
                                   cli::image_metric_names(false));
  if (!options.difference.empty()) io::require_image_format(options.difference);
  if (options.tested == "-" && options.reference == "-")
    throw Error("only one image can come from standard input");
  const auto values = options.raw_values ? io::CodeValues::raw : io::CodeValues::srgb;
  const auto read = [&](const std::string& path) {
    record.input(path);
    return record.timed("read", [&] { return io::read_image(path, values); });
  };
  Image tested = read(options.tested);
  Image reference = read(options.reference);
  if (tested.width != reference.width || tested.height != reference.height) {
    throw Error(io::display_name(options.tested) + " is " + std::to_string(tested.width) + "x" +
                std::to_string(tested.height) + ", " + io::display_name(options.reference) + " is " +
                std::to_string(reference.width) + "x" + std::to_string(reference.height) +
                ": the sizes must be the same");
  }
  const auto pairs = channel_pairs(options, tested, reference);
  const auto under = background(options, tested, reference);
  if (options.channels.empty()) {
    tested = image::composited(std::move(tested), under);
    reference = image::composited(std::move(reference), under);
  }
  const auto asked = cli::chosen_image_metrics(options.metrics, nullptr);
  const bool ssim = thresholds.name("ssim") ||
                    std::any_of(asked.begin(), asked.end(), [](const auto& m) { return m.name == "ssim"; });
  const image::ErrorOptions error_options{.peak = peak(options, reference, pairs), .ssim = ssim};
  const auto error =
      record.repeated("compare", [&] { return image::compare(tested, reference, pairs, error_options); });

  const auto metrics = cli::chosen_image_metrics(options.metrics, &error.all);
  nlohmann::json result = cli::to_json(error, metrics);
  result["width"] = tested.width;
  result["height"] = tested.height;
  result["background"] = under;
  record.resolved("background", under);
  record.error("image", result);
  const bool good =
      thresholds.hold([&](const std::string& metric) { return cli::image_figure(metric, error); }, record);
  if (thresholds.any()) {
    result["pass"] = good;
    record.result("pass", good);
  }
  if (!options.difference.empty()) write_difference(options, tested, reference, pairs, record);
  if (options.difference == "-") return good ? 0 : 1;  // standard output is taken by the picture
  if (options.json) {
    std::printf("%s\n", result.dump(2).c_str());
  } else {
    std::fputs(cli::table_of(error, metrics).c_str(), stdout);
  }
  return good ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Error of an image against a reference: MSE, RMSE, MAE, maximum, PSNR and SSIM, per channel and "
      "together.\n"
      "Both are composited over the background in linear light; nothing is clamped; every pixel counts."};
  Options o;
  declare(app, o);
  return cli::run(
      app,
      {.name = "img-compare",
       .example = "img-compare picture.exr truth.exr --fail-above rmse_byte=0.5 --difference difference.png",
       .references = "Wang, Bovik, Sheikh & Simoncelli 2004 (SSIM)",
       .repeats = true},
      argc, argv, [&](cli::Record& record) { return compare_images(o, record); });
}
