// distance: lengths over a body from one place to another.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "base/frames.h"
#include "modeling/measure/geodesic.h"
#include "modeling/measure/plane_cut.h"
#include "modeling/measure/taut_tape.h"
#include "station/commands.h"
#include "station/loaded_model.h"
#include "station/measurement_output.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

enum class DistanceMethod { kPlane, kView, kGeodesic, kTape };

const std::map<std::string, DistanceMethod>& MethodNames() {
  static const std::map<std::string, DistanceMethod> kNames{{"plane", DistanceMethod::kPlane},
                                                            {"view", DistanceMethod::kView},
                                                            {"geodesic", DistanceMethod::kGeodesic},
                                                            {"tape", DistanceMethod::kTape}};
  return kNames;
}

struct DistanceOptions {
  std::string model;
  std::string from;
  std::string to;
  std::string via;
  std::string view;
  std::string method;
  bool paper = false;
  std::string json;
};

/// What was asked for, checked.
struct DistanceQuestion {
  SurfacePlace from;
  SurfacePlace to;
  SurfacePlace via;      ///< Of kPlane.
  Eigen::Vector3d view;  ///< Of kView: the direction of sight, from the camera to the body.
  DistanceMethod method = DistanceMethod::kGeodesic;
  CutMethod cut = CutMethod::kSpline;
};

std::optional<double> ParseFinite(std::string_view text) {
  double value = 0.0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// "a,b" as two numbers.
Result<Eigen::Vector2d> ParsePair(const std::string& option, const std::string& text, const std::string& example) {
  const std::size_t comma = text.find(',');
  const std::string_view all = text;
  const auto first = comma == std::string::npos ? std::nullopt : ParseFinite(all.substr(0, comma));
  const auto second = comma == std::string::npos ? std::nullopt : ParseFinite(all.substr(comma + 1));
  if (!first || !second) {
    return Fail("read " + option, "'" + text + "' is not two numbers with a comma", "give it like " + example);
  }
  return Eigen::Vector2d(*first, *second);
}

Result<SurfacePlace> ParsePlace(const std::string& option, const std::string& text) {
  const auto pair = ParsePair(option, text, option + " 90,1250 (degrees, mm)");
  if (!pair) return Fail(pair);
  return SurfacePlace{WrapAngle(RadiansFromDegrees(pair->x())), pair->y()};
}

/// The direction of sight of a camera at station angle AZ and elevation EL, degrees.
Result<Eigen::Vector3d> ParseSight(const std::string& text) {
  const auto pair = ParsePair("--view", text, "--view 90,0 (azimuth and elevation of the camera, degrees)");
  if (!pair) return Fail(pair);
  const double azimuth = RadiansFromDegrees(pair->x());
  const double elevation = RadiansFromDegrees(pair->y());
  if (std::abs(pair->y()) > 90.0) return Fail("read --view", "the elevation is over 90 degrees", "give -90 … 90");
  return Eigen::Vector3d(-std::cos(elevation) * std::cos(azimuth), -std::cos(elevation) * std::sin(azimuth),
                         -std::sin(elevation));
}

/// What goes with which method.
Status CheckOptions(const DistanceOptions& options, DistanceMethod method) {
  const std::string attempted = "measure a distance with --method " + options.method;
  const bool plane = method == DistanceMethod::kPlane;
  const bool view = method == DistanceMethod::kView;
  if (plane && options.via.empty()) return Fail(attempted, "--via is missing", "give the third point, --via θ,z");
  if (view && options.view.empty())
    return Fail(attempted, "--view is missing", "give the camera's place, --view AZ,EL");
  if (!plane && !options.via.empty()) return Fail(attempted, "--via was given", "it belongs to --method plane");
  if (!view && !options.view.empty()) return Fail(attempted, "--view was given", "it belongs to --method view");
  if (!plane && !view && options.paper) {
    return Fail(attempted, "--paper was given", "it belongs to --method plane and view");
  }
  return {};
}

Result<DistanceQuestion> ReadQuestion(const DistanceOptions& options) {
  DistanceQuestion question;
  question.method = MethodNames().at(options.method);
  question.cut = options.paper ? CutMethod::kPaper : CutMethod::kSpline;
  RETURN_IF_ERROR(CheckOptions(options, question.method));
  const auto from = ParsePlace("--from", options.from);
  if (!from) return Fail(from);
  const auto to = ParsePlace("--to", options.to);
  if (!to) return Fail(to);
  question.from = *from;
  question.to = *to;
  if (question.method == DistanceMethod::kPlane) {
    const auto via = ParsePlace("--via", options.via);
    if (!via) return Fail(via);
    question.via = *via;
  }
  if (question.method == DistanceMethod::kView) {
    const auto view = ParseSight(options.view);
    if (!view) return Fail(view);
    question.view = *view;
  }
  return question;
}

Result<SurfaceDistance> Answer(const MeasuredSurface& body, const DistanceQuestion& question) {
  switch (question.method) {
    case DistanceMethod::kPlane:
      return DistanceByPlane(body, question.from, question.via, question.to, question.cut);
    case DistanceMethod::kView:
      return DistanceByView(body, question.from, question.to, question.view, question.cut);
    case DistanceMethod::kGeodesic:
      return GeodesicDistance(body, question.from, question.to);
    case DistanceMethod::kTape:
      return TautTape(body, question.from, question.to);
  }
  return GeodesicDistance(body, question.from, question.to);
}

Status RunDistance(const DistanceOptions& options, CommandIo& io) {
  const auto question = ReadQuestion(options);
  if (!question) {  // what was typed is wrong, whatever the model is
    io.set_failure_code(2);
    return Fail(question);
  }
  const auto loaded = LoadModel(io, options.model);
  if (!loaded) return Fail(loaded);
  const auto distance = Answer(loaded->body, *question);
  if (!distance) return Fail(distance);
  const Uncertain length = loaded->body.WithSigma(distance->length);
  const double rim = RimShare(loaded->body.surface(), distance->path);
  const double measured = distance->knowledge.measured;
  if (options.json.empty()) {
    std::string text = fmt::format("{} distance {:.2f} mm {}, {:.1f} % measured\n", options.method, length.value,
                                   HalfWidth95Text(length, 2), 100.0 * measured);
    if (rim > 0.0) {
      text += fmt::format("{:.1f} % of it runs along the rim of the scanned range: the way beyond may be shorter\n",
                          100.0 * rim);
    }
    return io.Print(text);
  }
  Json path = Json::array();
  for (const PathPoint& point : distance->path) {
    path.push_back({point.position.x(), point.position.y(), point.position.z()});
  }
  return io.WriteJson(options.json, {{"length_mm", length.value},
                                     {"method", options.method},
                                     {"discretisation", options.paper ? "paper" : "spline"},
                                     {"sigma_mm", JsonNumber(length.sigma)},
                                     {"measured_share", measured},
                                     {"rim_share", rim},
                                     {"path", std::move(path)}});
}

}  // namespace

void AddDistanceCommand(CLI::App& app, CommandWork& chosen) {
  auto options = std::make_shared<DistanceOptions>();
  CLI::App* command = app.add_subcommand("distance", "length over the body from one place to another");
  command->add_option("model", options->model, "model")->required();
  command->add_option("--from", options->from, "first place: angle (front 90 deg) and height, mm")
      ->required()
      ->type_name("θ,z");
  command->add_option("--to", options->to, "last place")->required()->type_name("θ,z");
  command->add_option("--via", options->via, "third point of the plane; for plane")->type_name("θ,z");
  command->add_option("--view", options->view, "azimuth and elevation of the camera, deg; for view")
      ->type_name("AZ,EL");
  std::vector<std::string> names;
  for (const auto& [name, method] : MethodNames()) names.push_back(name);
  command
      ->add_option("--method", options->method,
                   "plane (cut through three points), view (cut in the direction of sight), geodesic (shortest on the "
                   "skin), tape (taut, over hollows)")
      ->required()
      ->check(CLI::IsMember(names).description(""))
      ->type_name("plane|view|geodesic|tape");
  command->add_flag("--paper", options->paper, "cut the scan's own lattice as paper 001 does; for plane and view");
  AddJsonOption(*command, options->json);
  command->footer("Example: annulus distance model.json --from 60,1250 --to 120,1250 --method tape --json -");
  command->callback([&chosen, options] { chosen = [options](CommandIo& io) { return RunDistance(*options, io); }; });
}

}  // namespace annulus
