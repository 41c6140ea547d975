// landmarks: what was found on a model, and what a person says instead.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "modeling/exchange/landmarks_json.h"
#include "modeling/landmarks/landmarks.h"
#include "station/commands.h"
#include "station/loaded_model.h"
#include "station/measurement_output.h"

namespace annulus {
namespace {

struct LandmarksOptions {
  std::string model;
  std::vector<std::string> set;
  std::string out;
  std::string json;
};

std::optional<double> ParsedNumber(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// "id=THETA,Z" (degrees, mm) of a point, "id=Z" of a level.
Result<GivenLandmark> ParseSet(const std::string& text) {
  const std::string attempted = "read --set " + text;
  const std::string advice = "give a point as ID=THETA,Z in degrees and mm, a level as ID=Z in mm";
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) return Fail(attempted, "it has no '='", advice);
  const std::string_view place = std::string_view(text).substr(equals + 1);
  const std::size_t comma = place.find(',');
  GivenLandmark given;
  given.id = text.substr(0, equals);
  if (comma != std::string_view::npos) {
    const std::optional<double> theta = ParsedNumber(place.substr(0, comma));
    if (!theta) return Fail(attempted, "THETA is not a number", advice);
    given.theta = RadiansFromDegrees(*theta);
  }
  const std::optional<double> z = ParsedNumber(comma == std::string_view::npos ? place : place.substr(comma + 1));
  if (!z) return Fail(attempted, "Z is not a number", advice);
  given.z = *z;
  return given;
}

std::string HalfText(double sigma) {
  return std::isfinite(sigma) ? fmt::format("{:.1f}", HalfWidth95({0.0, sigma})) : "–";
}

std::string LineOf(const MeasuredSurface& body, const Landmark& landmark) {
  const bool is_point = landmark.kind == LandmarkKind::kPoint;
  const double up = std::hypot(body.WithSigma(landmark.z).sigma, landmark.placing_up);
  const double across =
      std::hypot(landmark.position.head<2>().norm() * body.WithSigma(landmark.theta).sigma, landmark.placing_across);
  return fmt::format("{:<26} {:<34} {:>8} {:>9.1f}  {:>7} {:>7}  {:>8.0f} %  {}\n", landmark.id, landmark.term,
                     is_point ? fmt::format("{:.1f}", DegreesFromRadians(landmark.theta.value)) : "", landmark.z.value,
                     is_point ? HalfText(across) : "", HalfText(up), 100.0 * landmark.confidence,
                     LandmarkSourceName(landmark.source));
}

std::string LandmarksText(const MeasuredSurface& body, const Landmarks& landmarks) {
  std::string text = fmt::format("{:<26} {:<34} {:>8} {:>9}  {:>7} {:>7}  {:>10}  {}\n", "id", "term", "theta/°",
                                 "z/mm", "± along", "± up", "confidence", "source");
  for (const Landmark& landmark : landmarks.found) text += LineOf(body, landmark);
  for (const std::string& sentence : landmarks.omitted) text += "not found: " + sentence + "\n";
  return text + "± along, ± up: half widths of the 95 % intervals along the skin horizontally and in height, mm\n";
}

Status RunLandmarks(const LandmarksOptions& options, CommandIo& io) {
  std::vector<GivenLandmark> given;
  for (const std::string& text : options.set) {
    auto parsed = ParseSet(text);
    if (!parsed) {
      io.set_failure_code(2);
      return Fail(parsed);
    }
    given.push_back(std::move(*parsed));
  }
  const auto loaded = LoadModel(io, options.model);
  if (!loaded) return Fail(loaded);
  Landmarks landmarks = FindLandmarks(loaded->body, {});
  for (const GivenLandmark& landmark : given) {
    auto edited = SetByHand(loaded->body, landmarks, landmark);
    if (!edited) return Fail(edited);
    landmarks = std::move(*edited);
  }
  if (landmarks.found.empty()) {
    return Fail("find landmarks on " + options.model, "there are none", "scan again with the whole body in the ring");
  }
  const std::string document = LandmarksToJson(loaded->body, landmarks);
  if (!options.out.empty()) RETURN_IF_ERROR(io.WriteText(options.out, document));
  if (!options.json.empty()) return io.WriteJson(options.json, nlohmann::ordered_json::parse(document));
  return options.out.empty() ? io.Print(LandmarksText(loaded->body, landmarks)) : Status{};
}

}  // namespace

void AddLandmarksCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<LandmarksOptions>();
  CLI::App* command = app.add_subcommand("landmarks", "find landmarks, or set them by hand");
  command->add_option("model", options->model, "model")->required();
  command
      ->add_option("--set", options->set,
                   "set a point, ID=THETA,Z in degrees and mm, or a level, ID=Z in mm; may be repeated")
      ->type_name("ID=PLACE")
      ->allow_extra_args(false);
  command->add_option("--out", options->out, "landmarks to write, for 'measure --landmarks'")->type_name("F");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus landmarks model.json --set level.waist=1080 --out landmarks.json");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunLandmarks(*options, io); }; });
}

}  // namespace annulus
