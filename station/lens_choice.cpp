#include "station/lens_choice.h"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <vector>

namespace annulus {
namespace {

constexpr std::string_view kOrderSection = "prescription";
constexpr std::string_view kChoiceSection = "lens_choice";
constexpr const char* kUsualMaterial = "cr39";

/// "1.56,37,1.28" as three numbers; empty if it is not that.
std::vector<double> ThreeNumbers(std::string_view text) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  while (at != end) {
    double value = 0.0;
    const auto [stop, error] = std::from_chars(at, end, value);
    if (error != std::errc()) return {};
    numbers.push_back(value);
    at = stop;
    if (at == end) break;
    if (*at != ',') return {};
    ++at;
  }
  return numbers.size() == 3 ? numbers : std::vector<double>();
}

nlohmann::ordered_json ToJson(const LensChoice& choice) {
  nlohmann::ordered_json json{{"material", choice.material}, {"as_prescribed", choice.as_prescribed}};
  if (choice.base_curve) json["base_curve_d"] = *choice.base_curve;
  if (choice.least_centre) json["least_centre_mm"] = *choice.least_centre;
  if (choice.least_edge) json["least_edge_mm"] = *choice.least_edge;
  return json;
}

/// Ranges of the command line and of files.
struct Range {
  double low;
  double high;
};
constexpr Range kBase{0.0, 16.0};      // D
constexpr Range kThinnest{0.3, 20.0};  // mm

Result<LensChoice> ChoiceFrom(std::string_view text, const std::string& path) {
  const auto refuse = [&path](std::string seen) {
    return Fail("read the lens choice of " + path, std::move(seen), "fit the glasses again with --rx");
  };
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) return refuse("it is no object");
  LensChoice choice;
  for (const auto& [key, value] : json.items()) {
    const auto take = [&value = value](std::optional<double>& number, const Range& range) {
      if (!value.is_number()) return false;
      number = value.get<double>();
      return *number >= range.low && *number <= range.high;
    };
    bool good = false;
    if (key == "material" && value.is_string()) {
      choice.material = value.get<std::string>();
      good = true;
    } else if (key == "as_prescribed" && value.is_boolean()) {
      choice.as_prescribed = value.get<bool>();
      good = true;
    } else if (key == "base_curve_d") {
      good = take(choice.base_curve, kBase);
    } else if (key == "least_centre_mm") {
      good = take(choice.least_centre, kThinnest);
    } else if (key == "least_edge_mm") {
      good = take(choice.least_edge, kThinnest);
    }
    if (!good) return refuse(fmt::format("'{}' is not known, of a wrong kind or out of its range", key));
  }
  return choice;
}

}  // namespace

void AddLensOptions(CLI::App& command, LensChoice& choice) {
  command
      .add_option("--lens-material", choice.material,
                  "what the lenses are made of: cr39 (the default), crown-glass, trivex, polycarbonate, 1.60, 1.67, "
                  "1.74, or its index, "
                  "Abbe number and density")
      ->type_name("NAME|INDEX,ABBE,DENSITY");
  command.add_option("--base-curve", choice.base_curve, "front curve of both lenses; without it by Vogel's rule")
      ->type_name("D")
      ->check(CLI::Range(kBase.low, kBase.high).description(""));
  command.add_option("--min-centre", choice.least_centre, "least thickness at the centre")
      ->type_name("MM")
      ->check(CLI::Range(kThinnest.low, kThinnest.high).description(""));
  command.add_option("--min-edge", choice.least_edge, "least thickness of the edge")
      ->type_name("MM")
      ->check(CLI::Range(kThinnest.low, kThinnest.high).description(""));
  command.add_flag("--as-prescribed", choice.as_prescribed,
                   "lenses made to the prescription itself, not so that they give it as worn");
}

Result<LensMaterial> MaterialOf(const LensChoice& choice) {
  const std::vector<double> numbers = ThreeNumbers(choice.material);
  if (numbers.empty()) return FindLensMaterial(choice.material.empty() ? kUsualMaterial : choice.material);
  const LensMaterial material{choice.material, numbers[0], SpectralLine::kE, numbers[1], numbers[2]};
  const Status valid = Validate(material);
  if (!valid) return Fail(valid);
  return material;
}

LensOptions LensOptionsOf(const LensChoice& choice) {
  LensOptions options;
  if (choice.base_curve) {
    options.base_rule = BaseCurveRule::kGiven;
    options.given_base = *choice.base_curve;
  }
  options.minimum_centre = choice.least_centre.value_or(options.minimum_centre);
  options.minimum_edge = choice.least_edge.value_or(options.minimum_edge);
  if (choice.as_prescribed) options.power_order = PowerOrder::kAsPrescribed;
  return options;
}

LensChoice Completed(const LensChoice& given, const LensChoice& kept) {
  LensChoice both = given;
  if (both.material.empty()) both.material = kept.material;
  if (!both.base_curve) both.base_curve = kept.base_curve;
  if (!both.least_centre) both.least_centre = kept.least_centre;
  if (!both.least_edge) both.least_edge = kept.least_edge;
  both.as_prescribed = both.as_prescribed || kept.as_prescribed;
  return both;
}

void KeepOrder(const Prescription& order, const LensChoice& choice, WornFile& file) {
  file.SetSection(kOrderSection, PrescriptionToJson(order));
  file.SetSection(kChoiceSection, ToJson(choice).dump());
}

Result<std::optional<KeptOrder>> KeptOrderOf(const WornFile& file, const std::string& path) {
  const std::string_view text = file.Section(kOrderSection);
  if (text.empty()) return std::optional<KeptOrder>();
  auto order = PrescriptionFromJson(text, path + ", prescription");
  if (!order) return Fail(order);
  const std::string_view chosen = file.Section(kChoiceSection);
  auto choice = chosen.empty() ? Result<LensChoice>(LensChoice{}) : ChoiceFrom(chosen, path);
  if (!choice) return Fail(choice);
  return std::optional<KeptOrder>({std::move(*order), std::move(*choice)});
}

}  // namespace annulus
