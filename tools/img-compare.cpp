// img-compare: error of one image against another.
//   img-compare picture.exr truth.exr
//   img-compare picture.exr truth.exr --json --fail-above rmse_byte=0.5 --difference difference.png
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "cli/options.h"
#include "cli/run.h"
#include "cli/threshold.h"
#include "image/difference.h"
#include "image/metrics.h"
#include "io/file.h"
#include "io/image.h"
#include "io/write_image.h"

namespace {

using nlohmann::json;
using vol::image::ChannelError;
using vol::image::ChannelPair;
using vol::image::Image;

struct Metric {
  const char* name;
  bool shown;  // in the table, unless --metric says else
  bool less_is_better;
  double (*of)(const ChannelError& error, double peak);
};

const std::vector<Metric> kMetrics{
    {"mse", true, true, [](const ChannelError& e, double) { return e.mse; }},
    {"rmse", true, true, [](const ChannelError& e, double) { return rmse(e); }},
    {"mse_byte", false, true, [](const ChannelError& e, double peak) { return mse_byte(e, peak); }},
    {"rmse_byte", true, true, [](const ChannelError& e, double peak) { return rmse_byte(e, peak); }},
    {"mae", true, true, [](const ChannelError& e, double) { return e.mae; }},
    {"max", true, true, [](const ChannelError& e, double) { return e.maximum; }},
    {"psnr", true, false, [](const ChannelError& e, double peak) { return psnr(e, peak); }},
    {"ssim", true, false, [](const ChannelError& e, double) { return e.ssim; }},
    {"nan", false, true,
     [](const ChannelError& e, double) { return static_cast<double>(e.nan_tested + e.nan_reference); }},
    {"infinite", false, true,
     [](const ChannelError& e, double) {
       return static_cast<double>(e.infinite_tested + e.infinite_reference);
     }},
};

const Metric& metric(const std::string& name) {
  for (const auto& m : kMetrics) {
    if (m.name == name) return m;
  }
  throw vol::Error("unknown metric " + name);
}

std::vector<std::string> metric_names(std::optional<bool> less_is_better = {}) {
  std::vector<std::string> names;
  for (const auto& m : kMetrics) {
    if (!less_is_better || m.less_is_better == *less_is_better) names.emplace_back(m.name);
  }
  return names;
}

struct Options {
  std::string tested, reference, difference, background, peak = "1";
  std::vector<std::string> channels, metrics, fail_above, fail_below;
  bool json = false, raw_values = false, is_signed = false;
  double difference_scale = 0;
};

struct Thresholds {
  std::vector<vol::cli::Threshold> above, below;
};

Thresholds parse_thresholds(const Options& options) {
  Thresholds thresholds;
  for (const auto& text : options.fail_above) {
    thresholds.above.push_back(vol::cli::parse_threshold("--fail-above", text, metric_names(true)));
  }
  for (const auto& text : options.fail_below) {
    thresholds.below.push_back(vol::cli::parse_threshold("--fail-below", text, metric_names(false)));
  }
  return thresholds;
}

/// What to show; without --metric the usual ones, and the counts of NaN and infinity where there are any.
std::vector<Metric> chosen_metrics(const Options& options, const ChannelError* all) {
  std::vector<Metric> chosen;
  for (const auto& m : kMetrics) {
    const bool named =
        std::find(options.metrics.begin(), options.metrics.end(), m.name) != options.metrics.end();
    const bool telling = all != nullptr &&
                         (m.name == std::string("nan") || m.name == std::string("infinite")) &&
                         m.of(*all, 1) > 0;
    if (options.metrics.empty() ? m.shown || telling : named) chosen.push_back(m);
  }
  return chosen;
}

bool needs_ssim(const Options& options, const Thresholds& thresholds) {
  for (const auto& m : chosen_metrics(options, nullptr)) {
    if (m.name == std::string("ssim")) return true;
  }
  for (const auto& t : thresholds.below) {
    if (t.metric == "ssim") return true;
  }
  return false;
}

std::array<double, 3> background(const Options& options, const Image& tested, const Image& reference) {
  std::string text = options.background;
  std::string source = "--background";
  if (text.empty()) {
    const auto a = tested.attributes.find("precis.background");
    const auto b = reference.attributes.find("precis.background");
    if (a == tested.attributes.end() || b == reference.attributes.end()) return {0, 0, 0};
    if (a->second != b->second) {
      throw vol::Error("the images were rendered over different backgrounds, " + a->second + " and " +
                       b->second + "; give --background");
    }
    text = a->second;
    source = "precis.background";
  }
  std::erase_if(text, [](char c) { return c == '[' || c == ']' || c == ' '; });
  const vol::Vec3 rgb = vol::cli::parse_vec3(source, text);
  return {rgb[0], rgb[1], rgb[2]};
}

/// Colour against colour, grey standing for three equal channels, or the named channels as they are.
std::vector<ChannelPair> channel_pairs(const Options& options, const Image& tested, const Image& reference) {
  std::vector<ChannelPair> pairs;
  for (const auto& name : options.channels) {
    const auto t = tested.channel(name);
    const auto r = reference.channel(name);
    if (!t) throw vol::Error(options.tested + ": has no channel " + name);
    if (!r) throw vol::Error(options.reference + ": has no channel " + name);
    pairs.push_back({name, *t, *r});
  }
  if (!pairs.empty()) return pairs;
  const auto colour = [](const std::string& path, const Image& image) {
    try {
      return vol::image::colour_channels(image);
    } catch (const vol::Error& cause) {
      throw vol::Error(vol::io::display_name(path),
                       vol::Error(std::string(cause.what()) + "; name one with --channel"));
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
    value = vol::image::largest_value(reference, channels);
    if (!(value > 0)) throw vol::Error(options.reference + ": has no positive value to take as --peak truth");
    return value;
  }
  char* end = nullptr;
  value = std::strtod(options.peak.c_str(), &end);
  if (end == options.peak.c_str() || *end != '\0' || !(value > 0) || !std::isfinite(value)) {
    throw vol::Error("--peak " + options.peak + ": expected a positive number or truth");
  }
  return value;
}

json figures(const ChannelError& error, double peak, const std::vector<Metric>& metrics) {
  json result;
  for (const auto& m : metrics) result[m.name] = vol::cli::figure(m.of(error, peak));
  result["max_at"] = error.maximum_x < 0 ? json() : json{error.maximum_x, error.maximum_y};
  return result;
}

json to_json(const vol::image::ImageError& error, const Image& image, const std::vector<Metric>& metrics) {
  json result{{"width", image.width},
              {"height", image.height},
              {"peak", error.peak},
              {"all", figures(error.all, error.peak, metrics)}};
  for (const auto& channel : error.channels)
    result["channels"][channel.name] = figures(channel, error.peak, metrics);
  return result;
}

void print_table(const vol::image::ImageError& error, const std::vector<Metric>& metrics) {
  std::printf("%-10s", "channel");
  for (const auto& m : metrics) std::printf(" %12s", m.name);
  std::printf("  max at\n");
  const auto row = [&](const ChannelError& e) {
    std::printf("%-10s", e.name.c_str());
    for (const auto& m : metrics) std::printf(" %12s", vol::cli::figure_text(m.of(e, error.peak)).c_str());
    if (e.maximum_x >= 0) {
      std::printf("  %d,%d%s%s", e.maximum_x, e.maximum_y, &e == &error.all ? " " : "",
                  &e == &error.all ? e.maximum_channel.c_str() : "");
    }
    std::printf("\n");
  };
  for (const auto& channel : error.channels) row(channel);
  row(error.all);
}

/// True where every threshold holds. An undefined figure holds none: NaN in the data is a difference, and a
/// structural similarity that does not exist cannot be asked for.
bool within(const vol::image::ImageError& error, const Thresholds& thresholds,
            const vol::cli::Record& record) {
  bool good = true;
  const auto check = [&](const vol::cli::Threshold& t, bool above) {
    const double value = metric(t.metric).of(error.all, error.peak);
    if (above ? value <= t.value : value >= t.value) return;
    good = false;
    record.say(std::isnan(value) ? t.metric + " is undefined"
                                 : t.metric + " " + vol::cli::figure_text(value) + " is not at " +
                                       (above ? "most " : "least ") + vol::cli::figure_text(t.value));
  };
  for (const auto& t : thresholds.above) check(t, true);
  for (const auto& t : thresholds.below) check(t, false);
  return good;
}

void write_difference(const Options& options, const Image& tested, const Image& reference,
                      const std::vector<ChannelPair>& pairs, vol::cli::Record& record) {
  using vol::image::DifferenceKind;
  const auto kind = options.is_signed ? DifferenceKind::signed_ : DifferenceKind::absolute;
  Image picture = vol::image::difference(tested, reference, pairs, kind);
  auto attributes = record.provenance();
  std::string key;  // to the colours
  if (std::filesystem::path(options.difference).extension() == ".png") {
    const double largest = vol::image::largest_magnitude(picture);
    const double scale = options.difference_scale > 0 ? options.difference_scale : largest > 0 ? largest : 1;
    picture = vol::image::false_colour(picture, scale, kind);
    const std::string text = vol::cli::figure_text(scale);
    attributes["precis.difference_scale"] = text;
    key = options.is_signed ? "difference: blue -" + text + ", white 0, red " + text
                            : "difference: black 0, light yellow " + text;
  }
  picture.attributes = std::move(attributes);
  record.timed("write", [&] { vol::io::write_image(options.difference, picture); });
  record.output(options.difference);
  if (!key.empty()) record.say(key);
}

int compare_images(const Options& options, vol::cli::Record& record) {
  const Thresholds thresholds = parse_thresholds(options);
  if (!options.difference.empty()) vol::io::require_image_format(options.difference);
  if (options.tested == "-" && options.reference == "-")
    throw vol::Error("only one image can come from standard input");
  const auto values = options.raw_values ? vol::io::CodeValues::raw : vol::io::CodeValues::srgb;
  const auto read = [&](const std::string& path) {
    record.input(path);
    return record.timed("read", [&] { return vol::io::read_image(path, values); });
  };
  Image tested = read(options.tested);
  Image reference = read(options.reference);
  if (tested.width != reference.width || tested.height != reference.height) {
    throw vol::Error(vol::io::display_name(options.tested) + " is " + std::to_string(tested.width) + "x" +
                     std::to_string(tested.height) + ", " + vol::io::display_name(options.reference) +
                     " is " + std::to_string(reference.width) + "x" + std::to_string(reference.height) +
                     ": the sizes must be the same");
  }
  const auto pairs = channel_pairs(options, tested, reference);
  const auto under = background(options, tested, reference);
  if (options.channels.empty()) {
    tested = vol::image::composited(std::move(tested), under);
    reference = vol::image::composited(std::move(reference), under);
  }
  const vol::image::ErrorOptions error_options{.peak = peak(options, reference, pairs),
                                               .ssim = needs_ssim(options, thresholds)};
  const auto error = record.repeated(
      "compare", [&] { return vol::image::compare(tested, reference, pairs, error_options); });

  const auto metrics = chosen_metrics(options, &error.all);
  json result = to_json(error, tested, metrics);
  result["background"] = under;
  record.resolved("background", under);
  record.error("image", result);
  const bool good = within(error, thresholds, record);
  if (!thresholds.above.empty() || !thresholds.below.empty()) {
    result["pass"] = good;
    record.result("pass", good);
  }
  if (!options.difference.empty()) write_difference(options, tested, reference, pairs, record);
  if (options.difference == "-") return good ? 0 : 1;  // standard output is taken by the picture
  if (options.json) {
    std::printf("%s\n", result.dump(2).c_str());
  } else {
    print_table(error, metrics);
  }
  return good ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App app{
      "Error of an image against a reference: MSE, RMSE, MAE, maximum, PSNR and SSIM, per channel and "
      "together.\n"
      "Both are composited over the background in linear light; nothing is clamped; every pixel counts."};
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
      ->check(CLI::IsMember(metric_names()))
      ->group("Figures");
  app.add_flag("--json", o.json,
               "JSON instead of a table; what is infinite or undefined stands as \"inf\", \"-inf\", \"nan\"")
      ->group("Figures");
  app.add_flag("--signed", o.is_signed, "Difference picture of image - reference, not of its magnitude")
      ->group("Figures");
  app.add_option("--difference-scale", o.difference_scale,
                 "Difference shown in the last colour of a .png; default: the largest")
      ->type_name("VALUE")
      ->check(vol::cli::check_positive)
      ->group("Figures");
  app.add_option("--fail-above", o.fail_above,
                 "Exit with 1 unless METRIC of all channels is at most VALUE; repeatable")
      ->type_name("METRIC=VALUE")
      ->allow_extra_args(false)
      ->group("Pass or fail");
  app.add_option("--fail-below", o.fail_below,
                 "Exit with 1 unless METRIC (psnr, ssim) is at least VALUE; repeatable")
      ->type_name("METRIC=VALUE")
      ->allow_extra_args(false)
      ->group("Pass or fail");
  return vol::cli::run(
      app,
      {.name = "img-compare",
       .example = "img-compare picture.exr truth.exr --fail-above rmse_byte=0.5 --difference difference.png",
       .references = "Wang, Bovik, Sheikh & Simoncelli 2004 (SSIM)",
       .repeats = true},
      argc, argv, [&](vol::cli::Record& record) { return compare_images(o, record); });
}
