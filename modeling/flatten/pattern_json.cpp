#include "modeling/flatten/pattern_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/units.h"
#include "modeling/glasses/json_reader.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "annulus pattern";
constexpr int kVersion = 1;
constexpr const char* kAdvice = "see docs/formats.md, 'Pattern'";
constexpr std::size_t kMost = 1000;   ///< Lines, pieces, places of a line.
constexpr double kMostTurn = 3600.0;  ///< deg

/// Thrown by what follows, caught in PatternFromJson.
struct BadPattern {
  Error error;
};

template <class T>
T Taken(Result<T> result) {
  if (!result) throw BadPattern{result.error()};
  return std::move(*result);
}

class Reader {
 public:
  explicit Reader(const JsonReader& reader) : reader_(reader) {}

  Pattern Read(const Json& root) {
    Keys(reader_, root,
         {"format", "version", "name", "material", "element_mm", "allowance_mm", "darts", "lines", "pieces"});
    Pattern pattern;
    pattern.name = Taken(reader_.Text(root, "name"));
    if (root.contains("material")) pattern.material = Material(*Taken(reader_.Object(root, "material")));
    pattern.element_mm = Ranged(reader_, root, "element_mm", pattern.element_mm, {0.1, 1000.0});
    pattern.allowance_mm = Ranged(reader_, root, "allowance_mm", pattern.allowance_mm, {0.0, 200.0});
    if (root.contains("darts")) pattern.darts = Rule(*Taken(reader_.Object(root, "darts")));
    for (const auto& [id, line] : Taken(reader_.Object(root, "lines"))->items())
      pattern.lines.push_back(Line(id, line));
    const Json& pieces = List(reader_, root, "pieces");
    if (pattern.lines.size() > kMost || pieces.empty()) Refuse("it has no pieces, or too many lines");
    for (std::size_t k = 0; k < pieces.size(); ++k) pattern.pieces.push_back(Piece(pattern, pieces, k));
    return pattern;
  }

 private:
  struct Range {
    double low, high;
  };

  [[noreturn]] void Refuse(std::string seen) const { throw BadPattern{reader_.Refuse(std::move(seen)).value()}; }
  static void Keys(const JsonReader& at, const Json& json, std::initializer_list<std::string_view> known) {
    if (!json.is_object()) throw BadPattern{at.Refuse(at.Named("") + " is not an object").value()};
    const Status status = at.OnlyKeys(json, known);
    if (!status) throw BadPattern{status.error()};
  }
  static const Json& List(const JsonReader& at, const Json& json, const char* key) {
    const Json& list = *Taken(at.Array(json, key));
    if (list.size() > kMost) throw BadPattern{at.Refuse(at.Named(key) + " has over 1000 members").value()};
    return list;
  }
  /// A number from low to high; `otherwise` if it is not there.
  static double Ranged(const JsonReader& at, const Json& json, const char* key, double otherwise, Range range) {
    if (!json.contains(key)) return otherwise;
    const double number = Taken(at.Number(json, key));
    if (number >= range.low && number <= range.high) return number;
    throw BadPattern{
        at.Refuse(fmt::format("{} is {:g}, not from {:g} to {:g}", at.Named(key), number, range.low, range.high))
            .value()};
  }
  static std::string TextOr(const JsonReader& at, const Json& json, const char* key) {
    return json.contains(key) ? Taken(at.Text(json, key)) : std::string();
  }

  FlatMaterial Material(const Json& json) const {
    const JsonReader at = reader_.Within("material");
    Keys(at, json, {"e_warp_n_per_mm2", "e_weft_n_per_mm2", "poisson", "shear_n_per_mm2", "thickness_mm"});
    FlatMaterial material;
    material.e_warp = Ranged(at, json, "e_warp_n_per_mm2", material.e_warp, {1e-6, 1e6});
    material.e_weft = Ranged(at, json, "e_weft_n_per_mm2", material.e_warp, {1e-6, 1e6});
    material.poisson = Ranged(at, json, "poisson", material.poisson, {-1.0, 10.0});
    material.shear = Ranged(at, json, "shear_n_per_mm2", material.shear, {0.0, 1e6});
    material.thickness_mm = Ranged(at, json, "thickness_mm", material.thickness_mm, {1e-6, 100.0});
    const Status status = CheckMaterial(material);
    if (!status) throw BadPattern{status.error()};
    return material;
  }

  DartRule Rule(const Json& json) const {
    const JsonReader at = reader_.Within("darts");
    Keys(at, json, {"strain", "most", "seams"});
    DartRule rule;
    rule.strain = Ranged(at, json, "strain", rule.strain, {1e-4, 1.0});
    rule.most = static_cast<std::size_t>(Ranged(at, json, "most", 4.0, {0.0, 20.0}));
    rule.seams = static_cast<std::size_t>(Ranged(at, json, "seams", 0.0, {0.0, 20.0}));
    return rule;
  }

  static PatternPlace Place(const JsonReader& at, const Json& json) {
    Keys(at, json, {"at", "theta_of", "theta_deg", "z_of", "z_towards", "z_share", "z_mm"});
    PatternPlace place;
    place.theta_of = place.z_of = TextOr(at, json, "at");
    if (json.contains("theta_of")) place.theta_of = TextOr(at, json, "theta_of");
    if (json.contains("z_of")) place.z_of = TextOr(at, json, "z_of");
    place.z_towards = TextOr(at, json, "z_towards");
    place.turn = RadiansFromDegrees(Ranged(at, json, "theta_deg", 0.0, {-kMostTurn, kMostTurn}));
    place.up = Ranged(at, json, "z_mm", 0.0, {-1e5, 1e5});
    if (json.contains("z_share")) place.z_share = Ranged(at, json, "z_share", 0.0, {-1.0, 2.0});
    if (place.theta_of.empty() && !json.contains("theta_deg")) Missing(at, "theta_deg");
    if (place.z_of.empty() && !json.contains("z_mm") && !json.contains("z_share")) Missing(at, "z_mm");
    if (!place.z_towards.empty() && place.z_of.empty()) Missing(at, "z_of");
    return place;
  }
  [[noreturn]] static void Missing(const JsonReader& at, const char* key) {
    throw BadPattern{at.Refuse(at.Named(key) + " is missing").value()};
  }

  PatternLine Line(const std::string& id, const Json& json) const {
    const JsonReader at = reader_.Within("lines." + id);
    Keys(at, json, {"places", "course", "allowance_mm", "notches"});
    if (id.empty() || id[0] == '-') Refuse("a line's name is empty or begins with '-'");
    PatternLine line;
    line.id = id;
    const Json& places = List(at, json, "places");
    for (std::size_t k = 0; k < places.size(); ++k)
      line.places.push_back(Place(at.Within(fmt::format("places[{}]", k)), places[k]));
    if (line.places.size() < 2) throw BadPattern{at.Refuse(at.Named("places") + " has fewer than two").value()};
    const std::string course = TextOr(at, json, "course");
    if (course != "" && course != "straight" && course != "smooth") {
      throw BadPattern{at.Refuse(at.Named("course") + " is neither straight nor smooth").value()};
    }
    if (course == "smooth") line.course = PatternLine::Course::kSmooth;
    if (json.contains("allowance_mm")) line.allowance_mm = Ranged(at, json, "allowance_mm", 0.0, {0.0, 200.0});
    if (json.contains("notches")) {
      for (const Json& notch : List(at, json, "notches")) {
        const double share = notch.is_number() ? notch.get<double>() : 0.0;
        if (!(share > 0.0 && share < 1.0))
          throw BadPattern{at.Refuse(at.Named("notches") + " has one that is not between 0 and 1").value()};
        line.notches.push_back(share);
      }
    }
    return line;
  }

  /// The line's number; fails on an unknown one.
  std::size_t LineCalled(const Pattern& pattern, const std::string& id) const {
    for (std::size_t k = 0; k < pattern.lines.size(); ++k) {
      if (pattern.lines[k].id == id) return k;
    }
    Refuse("there is no line '" + id + "'");
  }

  PatternPiece Piece(const Pattern& pattern, const Json& list, std::size_t number) const {
    const JsonReader at = reader_.Within(fmt::format("pieces[{}]", number));
    const Json& json = list[number];
    Keys(at, json, {"id", "label", "outline", "grain", "darts", "divisions"});
    PatternPiece piece;
    piece.id = Taken(at.Text(json, "id"));
    piece.label = TextOr(at, json, "label");
    for (const Json& use : List(at, json, "outline")) {
      if (!use.is_string()) throw BadPattern{at.Refuse(at.Named("outline") + " is not of names").value()};
      std::string id = use.get<std::string>();
      const bool backward = id.starts_with("-");
      if (backward) id.erase(0, 1);
      piece.outline.push_back({LineCalled(pattern, id), backward ? LineUse::Way::kBackward : LineUse::Way::kForward});
    }
    if (piece.outline.empty()) throw BadPattern{at.Refuse(at.Named("outline") + " is empty").value()};
    if (json.contains("grain")) {
      const Json& grain = List(at, json, "grain");
      if (grain.size() != 2) throw BadPattern{at.Refuse(at.Named("grain") + " is not two places").value()};
      piece.grain = {Place(at.Within("grain[0]"), grain[0]), Place(at.Within("grain[1]"), grain[1])};
    }
    if (json.contains("darts")) {
      const Json& darts = List(at, json, "darts");
      for (std::size_t k = 0; k < darts.size(); ++k)
        piece.darts.push_back(Dart(pattern, at.Within(fmt::format("darts[{}]", k)), darts[k]));
    }
    if (json.contains("divisions")) {
      const Json& divisions = List(at, json, "divisions");
      for (std::size_t k = 0; k < divisions.size(); ++k)
        piece.divisions.push_back(Division(pattern, at.Within(fmt::format("divisions[{}]", k)), divisions[k]));
    }
    return piece;
  }

  PatternDivision Division(const Pattern& pattern, const JsonReader& at, const Json& json) const {
    Keys(at, json, {"from", "to", "through"});
    PatternDivision division;
    for (std::size_t k = 0; k < 2; ++k) {
      const char* key = k == 0 ? "from" : "to";
      const JsonReader within = at.Within(key);
      const Json& end = *Taken(at.Object(json, key));
      Keys(within, end, {"line", "share"});
      division.ends[k].line = LineCalled(pattern, Taken(within.Text(end, "line")));
      division.ends[k].share = Ranged(within, end, "share", 0.5, {0.001, 0.999});
    }
    if (json.contains("through")) {
      const Json& places = List(at, json, "through");
      for (std::size_t k = 0; k < places.size(); ++k)
        division.through.push_back(Place(at.Within(fmt::format("through[{}]", k)), places[k]));
    }
    return division;
  }

  PatternDart Dart(const Pattern& pattern, const JsonReader& at, const Json& json) const {
    Keys(at, json, {"line", "share", "tip"});
    PatternDart dart;
    dart.line = LineCalled(pattern, Taken(at.Text(json, "line")));
    dart.share = Ranged(at, json, "share", 0.5, {0.001, 0.999});
    dart.tip = Place(at.Within("tip"), *Taken(at.Object(json, "tip")));
    return dart;
  }

  const JsonReader& reader_;
};

Json PlaceJson(const PatternPlace& place) {
  Json json = Json::object();
  if (!place.theta_of.empty()) json["theta_of"] = place.theta_of;
  // The way to radians and back may step over the limit by a bit.
  json["theta_deg"] = std::clamp(DegreesFromRadians(place.turn), -kMostTurn, kMostTurn);
  if (!place.z_of.empty()) json["z_of"] = place.z_of;
  if (!place.z_towards.empty()) json["z_towards"] = place.z_towards;
  if (place.z_share) json["z_share"] = *place.z_share;
  json["z_mm"] = place.up;
  return json;
}

Json LineJson(const PatternLine& line) {
  Json places = Json::array();
  for (const PatternPlace& place : line.places) places.push_back(PlaceJson(place));
  Json json{{"places", std::move(places)},
            {"course", line.course == PatternLine::Course::kSmooth ? "smooth" : "straight"}};
  if (line.allowance_mm) json["allowance_mm"] = *line.allowance_mm;
  if (!line.notches.empty()) json["notches"] = line.notches;
  return json;
}

Json DivisionJson(const Pattern& pattern, const PatternDivision& division) {
  const auto end = [&](std::size_t k) {
    return Json{{"line", pattern.lines[division.ends[k].line].id}, {"share", division.ends[k].share}};
  };
  Json through = Json::array();
  for (const PatternPlace& place : division.through) through.push_back(PlaceJson(place));
  return {{"from", end(0)}, {"to", end(1)}, {"through", std::move(through)}};
}

Json PieceJson(const Pattern& pattern, const PatternPiece& piece) {
  Json outline = Json::array();
  for (const LineUse& use : piece.outline) {
    outline.push_back((use.way == LineUse::Way::kBackward ? "-" : "") + pattern.lines[use.line].id);
  }
  Json json{{"id", piece.id}, {"label", piece.label}, {"outline", std::move(outline)}};
  if (piece.grain) json["grain"] = {PlaceJson((*piece.grain)[0]), PlaceJson((*piece.grain)[1])};
  Json darts = Json::array();
  for (const PatternDart& dart : piece.darts) {
    darts.push_back({{"line", pattern.lines[dart.line].id}, {"share", dart.share}, {"tip", PlaceJson(dart.tip)}});
  }
  if (!darts.empty()) json["darts"] = std::move(darts);
  Json divisions = Json::array();
  for (const PatternDivision& division : piece.divisions) divisions.push_back(DivisionJson(pattern, division));
  if (!divisions.empty()) json["divisions"] = std::move(divisions);
  return json;
}

}  // namespace

Result<Pattern> PatternFromJson(std::string_view text, std::string_view name) {
  const JsonReader reader(name, kAdvice);
  const auto root = reader.Root(text);
  if (!root) return Fail(root);
  const auto version = reader.Version(*root, kFormat, kVersion);
  if (!version) return Fail(version);
  try {
    return Reader(reader).Read(*root);
  } catch (const BadPattern& bad) {
    return tl::unexpected<Error>(bad.error);
  }
}

std::string PatternToJson(const Pattern& pattern) {
  const FlatMaterial& m = pattern.material;
  Json lines = Json::object();
  for (const PatternLine& line : pattern.lines) lines[line.id] = LineJson(line);
  Json pieces = Json::array();
  for (const PatternPiece& piece : pattern.pieces) pieces.push_back(PieceJson(pattern, piece));
  const Json root{
      {"format", kFormat},
      {"version", kVersion},
      {"name", pattern.name},
      {"material",
       {{"e_warp_n_per_mm2", m.e_warp},
        {"e_weft_n_per_mm2", m.e_weft},
        {"poisson", m.poisson},
        {"shear_n_per_mm2", m.shear},
        {"thickness_mm", m.thickness_mm}}},
      {"element_mm", pattern.element_mm},
      {"allowance_mm", pattern.allowance_mm},
      {"darts", {{"strain", pattern.darts.strain}, {"most", pattern.darts.most}, {"seams", pattern.darts.seams}}},
      {"lines", std::move(lines)},
      {"pieces", std::move(pieces)}};
  return root.dump(1) + "\n";
}

bool NeedsLandmarks(const Pattern& pattern) {
  const auto named = [](const PatternPlace& place) { return !place.theta_of.empty() || !place.z_of.empty(); };
  for (const PatternLine& line : pattern.lines) {
    if (std::any_of(line.places.begin(), line.places.end(), named)) return true;
  }
  for (const PatternPiece& piece : pattern.pieces) {
    if (piece.grain && (named((*piece.grain)[0]) || named((*piece.grain)[1]))) return true;
    for (const PatternDart& dart : piece.darts) {
      if (named(dart.tip)) return true;
    }
    for (const PatternDivision& division : piece.divisions) {
      if (std::any_of(division.through.begin(), division.through.end(), named)) return true;
    }
  }
  return false;
}

std::string FlatPatternToJson(const FlatPattern& flat) {
  Json pieces = Json::array();
  for (const FlatPiece& piece : flat.pieces) {
    Json points = Json::array();
    Json places = Json::array();
    for (std::size_t v = 0; v < piece.points.size(); ++v) {
      points.push_back({piece.points[v].x(), piece.points[v].y()});
      places.push_back({DegreesFromRadians(piece.body.theta_z[v].x()), piece.body.theta_z[v].y()});
    }
    Json strains = Json::array();
    for (const Eigen::Vector3d& strain : piece.strains) strains.push_back({strain[0], strain[1], strain[2]});
    pieces.push_back({{"id", piece.id},
                      {"points_mm", std::move(points)},
                      {"theta_deg_z_mm", std::move(places)},
                      {"triangles", piece.body.sheet.faces},
                      {"strain_weft_warp_shear", std::move(strains)},
                      {"rim", piece.rim},
                      {"grain", piece.body.grain}});
  }
  const Json root{
      {"format", "annulus flat pattern"}, {"version", 1}, {"name", flat.name}, {"pieces", std::move(pieces)}};
  return root.dump() + "\n";
}

}  // namespace annulus
