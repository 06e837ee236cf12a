#include "cli/composite_options.h"

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "cli/options.h"
#include "io/file.h"

namespace vol::cli {

void add_composite(CLI::App& app, CompositeOptions& o) {
  const char* group = "Self-occlusion (--model composite)";
  app.add_option(
         "--transfer", o.transfer,
         "Composite: transfer function (YAML, or ParaView's .json), in place of the scene's [none: the "
         "field itself is the extinction of a white medium, exactly]")
      ->group("Files");
  app.add_option("--extinction", o.extinction,
                 "Without transfer function: extinction per unit of the field and world length [1]")
      ->check(check_positive)
      ->group(group);
  app.add_option(
         "--negative", o.negative,
         "Without transfer function: clamp (a field below 0 is 0, and counted) or keep [clamp; keep if "
         "linearised]")
      ->check(CLI::IsMember({"clamp", "keep"}))
      ->group(group);
  app.add_option(
         "--linearised", o.linearised,
         "Without transfer function and shading: transmittance as the product of 1 - dW, interval (dW "
         "between a basis function's knots, of first order) or basis (whole basis functions; does not "
         "converge) [no]")
      ->check(CLI::IsMember({"interval", "basis"}))
      ->group(group);
  app.add_option("--tolerance", o.tolerance,
                 "With transfer function or shading: absolute error of a pixel, on the colour scale "
                 "[1e-6]")
      ->check(check_positive)
      ->group(group);
}

render::CompositeOptions resolve(const CompositeOptions& o, io::SceneFile& file, Record& record) {
  const auto given = o.extinction   ? "--extinction"
                     : o.negative   ? "--negative"
                     : o.linearised ? "--linearised"
                                    : nullptr;
  if (file.scene.model != render::Model::composite) {
    const char* wrong = given != nullptr ? given : !o.transfer.empty() ? "--transfer" : "--tolerance";
    if (given != nullptr || !o.transfer.empty() || o.tolerance) {
      throw Error(std::string(wrong) + " is for --model composite");
    }
    return {};
  }
  if (!o.transfer.empty()) {
    if (io::is_standard_stream(o.transfer)) {
      throw Error("--transfer is a file: its name says what form it has");
    }
    record.input(o.transfer);
    file.scene.transfer = io::read_transfer_function(o.transfer);
    file.has_transfer = true;
  }
  if (file.has_transfer && given != nullptr) {
    throw Error(std::string(given) + ": the transfer function says what extinction is");
  }
  if (o.linearised && o.negative == "clamp") {
    throw Error("--negative clamp: what is linearised are basis functions, of both signs; give keep");
  }
  if (o.linearised && file.scene.shading) throw Error("--linearised: the scene must have no shading");
  if (o.tolerance && !file.has_transfer && !file.scene.shading) {
    throw Error("--tolerance is for a transfer function or shading: without them the integral is exact");
  }
  render::CompositeOptions result;
  result.transfer = file.has_transfer;
  result.extinction = o.extinction.value_or(1);
  result.keep_negative = o.negative == "keep" || o.linearised;
  if (o.linearised) {
    result.linearised = o.linearised == "interval" ? render::Linearised::interval : render::Linearised::basis;
  }
  return result;
}

void report(const render::RenderResult& result, const render::CompositeCounts& counts,
            const CompositeOptions& o, Record& record) {
  record.count("pieces", counts.pieces);
  record.count("evaluations", counts.evaluations);
  record.count("gradients", result.counts.gradients);
  record.count("clamped_pieces", counts.clamped_pieces);
  record.result("clamped_optical_depth_maximum", counts.clamped_depth);
  if (o.linearised) return;
  record.error("pixel_maximum_estimate", result.error_estimate);
  if (result.error_estimate > 10 * o.tolerance.value_or(kCompositeTolerance)) {
    record.warn("the integral reached an error of about " + std::to_string(result.error_estimate));
  }
}

}  // namespace vol::cli
