#include "modeling/elastic/elastic_script.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/frames.h"
#include "modeling/glasses/json_reader.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kAdvice = "see docs/formats.md, 'Elastic edit'";
constexpr std::size_t kMostEntries = 1000;
constexpr double kRadPerDeg = kTwoPi / 360.0;

/// Thrown within this file, caught in ElasticScriptFromJson.
struct BadScript {
  Error error;
};

/// Numbers of one object, each held against its range.
class Fields {
 public:
  Fields(const JsonReader& reader, const Json& json, std::initializer_list<std::string_view> known)
      : reader_(reader), json_(json) {
    if (!json.is_object()) throw BadScript{reader.Refuse(reader.Named("") + " is not an object").value()};
    if (const Status status = reader.OnlyKeys(json, known); !status) throw BadScript{status.error()};
  }

  [[nodiscard]] bool Has(const char* key) const { return json_.contains(key); }
  [[nodiscard]] double Number(const char* key, double least, double most) const {
    const auto number = reader_.Number(json_, key);
    if (!number) throw BadScript{number.error()};
    if (*number >= least && *number <= most) return *number;
    throw BadScript{
        reader_.Refuse(fmt::format("{} is {:g}, not {:g} to {:g}", reader_.Named(key), *number, least, most)).value()};
  }
  [[nodiscard]] double NumberOr(const char* key, double otherwise, double least, double most) const {
    return Has(key) ? Number(key, least, most) : otherwise;
  }
  [[nodiscard]] std::string Text(const char* key) const {
    auto text = reader_.Text(json_, key);
    if (!text) throw BadScript{text.error()};
    return *text;
  }
  [[noreturn]] void Refuse(const std::string& seen) const { throw BadScript{reader_.Refuse(seen).value()}; }
  [[nodiscard]] const JsonReader& reader() const { return reader_; }
  [[nodiscard]] const Json& json() const { return json_; }

 private:
  JsonReader reader_;
  const Json& json_;
};

SkinBump BumpOf(const Fields& fields) {
  SkinBump bump;
  bump.theta = kRadPerDeg * fields.Number("theta_deg", -720.0, 720.0);
  bump.z = fields.Number("z_mm", -1e5, 1e5);
  bump.radius = fields.Number("radius_mm", 1e-3, 1e4);
  return bump;
}

SkinBump EditOf(const Fields& fields) {
  SkinBump bump = BumpOf(fields);
  bump.outward = fields.Number("outward_mm", -1e3, 1e3);
  return bump;
}

BumpLoad LoadOf(const Fields& fields) {
  using As = BumpLoad::As;
  BumpLoad load;
  load.bump = BumpOf(fields);
  const std::string as = fields.Has("as") ? fields.Text("as") : "displacement";
  if (as == "force") {
    load.as = As::kForce;
    load.force = fields.Number("force_n", -1e4, 1e4);
  } else if (as == "displacement" || as == "pressure") {
    load.as = as == "pressure" ? As::kPressure : As::kDisplacement;
    load.bump.outward = fields.Number("outward_mm", -1e3, 1e3);
  } else {
    fields.Refuse(fmt::format("{} is '{}', none of displacement, pressure, force", fields.reader().Named("as"), as));
  }
  return load;
}

BandLoad BandOf(const Fields& fields) {
  BandLoad band;
  band.z = fields.Number("z_mm", -1e5, 1e5);
  band.width = fields.NumberOr("width_mm", band.width, 1.0, 1e3);
  if (fields.Has("normal")) {
    const auto normal = fields.reader().Vector(fields.json(), "normal");
    if (!normal) throw BadScript{normal.error()};
    if (!(normal->z() > 0.5 * normal->norm())) {
      fields.Refuse(fields.reader().Named("normal") + " leans over 60 degrees from the vertical");
    }
    band.normal = normal->normalized();
  }
  if (fields.Has("girth_mm")) {
    band.girth = fields.Number("girth_mm", 10.0, 1e4);
    if (fields.Has("rest_length_mm") || fields.Has("stiffness_n")) {
      fields.Refuse(fields.reader().Named("girth_mm") + " stands beside a rest length or stiffness");
    }
    return band;
  }
  band.rest_length = fields.Number("rest_length_mm", 10.0, 1e4);
  band.stiffness = fields.Number("stiffness_n", 1e-6, 1e6);
  return band;
}

RegionRequest RegionOf(const Fields& fields) {
  RegionRequest region;
  if (fields.Has("theta_from_deg") || fields.Has("theta_to_deg")) {
    region.theta_from = kRadPerDeg * fields.Number("theta_from_deg", -720.0, 720.0);
    region.theta_to = kRadPerDeg * fields.Number("theta_to_deg", -720.0, 1080.0);
  }
  region.z_min = fields.Number("z_min_mm", -1e5, 1e5);
  region.z_max = fields.Number("z_max_mm", -1e5, 1e5);
  region.thickness = fields.NumberOr("thickness_mm", region.thickness, 0.1, 1000.0);
  region.spacing = fields.NumberOr("spacing_mm", region.spacing, 1.0, 100.0);
  const double layers = fields.NumberOr("layers", static_cast<double>(region.layers - 1), 1.0, 8.0);
  if (layers != std::floor(layers)) fields.Refuse(fields.reader().Named("layers") + " is not a whole number");
  region.layers = static_cast<std::size_t>(layers) + 1;
  return region;
}

/// The entries of a list, read one by one.
template <class Read>
auto ListOf(const Fields& root, const char* key, std::initializer_list<std::string_view> known, Read read) {
  std::vector<decltype(read(root))> list;
  if (!root.Has(key)) return list;
  const auto array = root.reader().Array(root.json(), key);
  if (!array) throw BadScript{array.error()};
  if ((*array)->size() > kMostEntries) root.Refuse(fmt::format("{} has over {} entries", key, kMostEntries));
  for (std::size_t n = 0; n < (*array)->size(); ++n) {
    list.push_back(read(Fields(root.reader().Within(fmt::format("{}[{}]", key, n)), (**array)[n], known)));
  }
  return list;
}

ElasticScript ScriptOf(const JsonReader& reader, const Json& json) {
  const Fields root(reader, json, {"segment", "material", "method", "region", "edits", "loads", "bands", "girths_mm"});
  ElasticScript script;
  if (root.Has("segment")) script.segment = root.Text("segment");
  if (root.Has("material")) {
    const Fields material(reader.Within("material"), json["material"], {"young_kpa", "poisson"});
    script.material.young = 1e-3 * material.NumberOr("young_kpa", 1e3 * script.material.young, 1e-3, 1e6);
    script.material.poisson = material.NumberOr("poisson", script.material.poisson, 0.0, 0.49);
  }
  if (root.Has("method")) {
    const std::string method = root.Text("method");
    if (method != "linear" && method != "corotational") {
      root.Refuse(fmt::format("'method' is '{}', neither linear nor corotational", method));
    }
    script.method = method == "linear" ? ElasticMethod::kLinear : ElasticMethod::kCorotational;
  }
  if (root.Has("region")) {
    script.region = RegionOf(
        Fields(reader.Within("region"), json["region"],
               {"theta_from_deg", "theta_to_deg", "z_min_mm", "z_max_mm", "thickness_mm", "spacing_mm", "layers"}));
  }
  script.edits = ListOf(root, "edits", {"theta_deg", "z_mm", "outward_mm", "radius_mm"}, EditOf);
  script.loads = ListOf(root, "loads", {"theta_deg", "z_mm", "outward_mm", "radius_mm", "as", "force_n"}, LoadOf);
  script.bands =
      ListOf(root, "bands", {"z_mm", "normal", "width_mm", "rest_length_mm", "stiffness_n", "girth_mm"}, BandOf);
  if (root.Has("girths_mm")) {
    const auto heights = reader.Array(json, "girths_mm");
    if (!heights) throw BadScript{heights.error()};
    for (const Json& height : **heights) {
      if (!height.is_number() || script.girths.size() >= kMostEntries)
        root.Refuse("'girths_mm' is not a short list of numbers");
      script.girths.push_back(height.get<double>());
    }
  }
  if (!script.region && !(script.loads.empty() && script.bands.empty())) {
    root.Refuse("'region' is missing, which loads and bands act on");
  }
  return script;
}

}  // namespace

Result<ElasticScript> ElasticScriptFromJson(std::string_view text, std::string_view name) {
  const JsonReader reader(name, kAdvice);
  const auto root = reader.Root(text);
  if (!root) return Fail(root);
  try {
    return ScriptOf(reader, *root);
  } catch (const BadScript& bad) {
    return tl::unexpected<Error>(bad.error);
  }
}

}  // namespace annulus
