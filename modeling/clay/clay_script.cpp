#include "modeling/clay/clay_script.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "modeling/clay/clay_closest.h"
#include "modeling/glasses/json_reader.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

constexpr const char* kAdvice = "see docs/formats.md, 'Clay operations'";
constexpr std::size_t kMostSteps = 100'000;
constexpr double kRadPerDeg = std::numbers::pi / 180.0;

/// Thrown within this file by Fields, caught in ClayScriptFromJson.
struct BadStep {
  Error error;
};

/// Members of one operation; each is looked up once, and what nobody asked for is told.
class Fields {
 public:
  Fields(const JsonReader& reader, const Json& json) : reader_(reader), json_(json) {
    if (!json.is_object()) throw BadStep{reader.Refuse(reader.Named("") + " is not an object").value()};
  }

  [[nodiscard]] bool Has(const char* key) {
    known_.push_back(key);
    return json_.contains(key);
  }
  double Number(const char* key, double otherwise) {
    if (!Has(key)) return otherwise;
    return Taken(reader_.Number(json_, key));
  }
  double NeededNumber(const char* key) {
    known_.push_back(key);
    return Taken(reader_.Number(json_, key));
  }
  std::uint32_t Count(const char* key, std::uint32_t otherwise) {
    const double number = Number(key, otherwise);
    if (!(number >= 0.0 && number <= 4294967295.0 && number == std::floor(number))) {
      throw BadStep{reader_.Refuse(reader_.Named(key) + " is not a whole number from 0").value()};
    }
    return static_cast<std::uint32_t>(number);
  }
  template <class Value>
  Value OneOf(const char* key, const std::map<std::string, Value>& values, Value otherwise) {
    if (!Has(key)) return otherwise;
    const std::string text = Taken(reader_.Text(json_, key));
    const auto found = values.find(text);
    if (found != values.end()) return found->second;
    std::string names;
    for (const auto& [one, value] : values) names += (names.empty() ? "" : ", ") + one;
    throw BadStep{reader_.Refuse(fmt::format("{} is '{}', none of {}", reader_.Named(key), text, names)).value()};
  }
  /// false unless given.
  bool Flag(const char* key) {
    if (!Has(key)) return false;
    if (!json_.at(key).is_boolean()) Refuse(key, "is neither true nor false");
    return json_.at(key).get<bool>();
  }
  [[noreturn]] void Refuse(const char* key, const char* why) const {
    throw BadStep{reader_.Refuse(fmt::format("{} {}", reader_.Named(key), why)).value()};
  }
  ClayAddress Address() {
    ClayAddress at;
    if (!Has("patch")) throw BadStep{reader_.Refuse(reader_.Named("patch") + " is missing").value()};
    at.patch = Count("patch", 0);
    at.u = Number("u", 0.5);
    at.v = Number("v", 0.5);
    return at;
  }
  /// Where a tool is held: an address, or none yet, but the point that it is to be nearest to.
  ClayAddress Place() {
    if (!Has("near_mm")) return Address();
    near_ = NearBy("near_mm");
    return {};
  }
  [[nodiscard]] const std::optional<Vector3d>& near() const { return near_; }
  std::optional<Vector3d> Direction() {
    if (!Has("direction")) return {};
    return Taken(reader_.Vector(json_, "direction"));
  }
  /// A point at most a kilometre away: squares of distances stay numbers.
  Eigen::Vector3d NearBy(const char* key) {
    const Eigen::Vector3d point = Taken(reader_.Vector(json_, key));
    if (point.cwiseAbs().maxCoeff() > 1e6) Refuse(key, "is more than a kilometre away");
    return point;
  }
  ClayEnd End(const char* key) {
    known_.push_back(key);
    if (!json_.contains(key)) throw BadStep{reader_.Refuse(reader_.Named(key) + " is missing").value()};
    if (json_.at(key).is_array()) return NearBy(key);
    Fields inner(reader_.Within(key), json_.at(key));
    const ClayAddress at = inner.Address();
    inner.Done();
    return at;
  }
  std::vector<ClayAddress> Path(const char* key) {
    known_.push_back(key);
    const Json& list = *Taken(reader_.Array(json_, key));
    std::vector<ClayAddress> path;
    for (std::size_t n = 0; n < list.size(); ++n) {
      Fields inner(reader_.Within(fmt::format("{}[{}]", key, n)), list[n]);
      path.push_back(inner.Address());
      inner.Done();
    }
    return path;
  }
  /// Fails on a member that nobody has asked for.
  void Done() const {
    for (const auto& [key, value] : json_.items()) {
      if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
      throw BadStep{reader_.Refuse(reader_.Named(key) + " is not known here").value()};
    }
  }

 private:
  template <class T>
  static T Taken(Result<T> result) {
    if (!result) throw BadStep{result.error()};
    return std::move(*result);
  }

  JsonReader reader_;
  const Json& json_;
  std::vector<std::string> known_;
  std::optional<Vector3d> near_;
};

const std::map<std::string, ClayTool> kTools{{"finger", ClayTool::kFinger},
                                             {"hand", ClayTool::kHand},
                                             {"spatula", ClayTool::kSpatula},
                                             {"nippers", ClayTool::kNippers}};

std::map<std::string, ClayTool> ToolsOf(std::initializer_list<const char*> names) {
  std::map<std::string, ClayTool> tools;
  for (const char* name : names) tools.emplace(name, kTools.at(name));
  return tools;
}

/// A hold with one of the tools that table 1 marks; the first is meant where none is named.
ToolHold Hold(Fields& fields, std::initializer_list<const char*> tools) {
  ToolHold hold;
  hold.at = fields.Place();
  hold.tool = fields.OneOf("tool", ToolsOf(tools), kTools.at(*tools.begin()));
  hold.radius_mm = fields.Number("radius_mm", hold.radius_mm);
  hold.length_mm = fields.Number("length_mm", hold.length_mm);
  hold.angle_rad = kRadPerDeg * fields.Number("angle_deg", 0.0);
  hold.direction = fields.Direction();
  return hold;
}

double RhoOver(Fields& fields, double radius) { return fields.Number("rho_mm", 2.0 * radius) / radius; }

ClayStep Push(Fields& fields, double sign) {
  PushAct act;
  act.hold = Hold(fields, {"finger", "hand", "spatula"});
  act.depth_mm = sign * std::abs(fields.Number("depth_mm", act.depth_mm));
  act.model = static_cast<int>(fields.Count("model", 1));
  act.rho = RhoOver(fields, act.hold.radius_mm);
  return {act, {}, {}};
}

ClayStep Hole(Fields& fields) {
  using How = HoleAct::How;
  HoleAct act;
  act.hold = Hold(fields, {"finger", "spatula"});
  act.how =
      fields.OneOf<How>("how", {{"make", How::kMake}, {"widen", How::kWiden}, {"close", How::kClose}}, How::kMake);
  act.depth_mm = fields.Number("depth_mm", act.depth_mm);
  act.factor = fields.Number("factor", act.factor);
  if (fields.Flag("through")) {
    if (act.how == How::kWiden) fields.Refuse("through", "is for making and closing a hole");
    act.how = act.how == How::kMake ? How::kThrough : How::kFill;
  }
  return {act, {}, {}};
}

ClayStep Twist(Fields& fields) {
  TwistAct act;
  act.angle_rad = kRadPerDeg * fields.NeededNumber("angle_deg");
  return {act, std::array<ClayEnd, 2>{fields.End("from"), fields.End("to")}, {}};
}

ClayStep Stretch(Fields& fields) {
  StretchAct act;
  act.factor = fields.NeededNumber("factor");
  fields.OneOf("tool", ToolsOf({"hand", "spatula"}), ClayTool::kHand);
  return {act, std::array<ClayEnd, 2>{fields.End("from"), fields.End("to")}, {}};
}

ClayStep Ball(Fields& fields) {
  BallAct act;
  act.amount = fields.Number("amount", act.amount);
  return {act, {}, {}};
}

ClayStep Spread(Fields& fields) {
  SpreadAct act;
  act.hold = Hold(fields, {"hand"});
  act.amount = fields.Number("amount", act.amount);
  return {act, {}, {}};
}

ClayStep Knead(Fields& fields) {
  KneadAct act;
  act.amplitude_mm = fields.Number("amplitude_mm", act.amplitude_mm);
  act.wavelength_mm = fields.Number("wavelength_mm", act.wavelength_mm);
  act.seed = fields.Count("seed", 1);
  return {act, {}, {}};
}

ClayStep Line(Fields& fields) {
  using How = LineAct::How;
  LineAct act;
  act.tool = fields.OneOf("tool", ToolsOf({"spatula", "finger"}), ClayTool::kSpatula);
  act.how = fields.OneOf<How>("how", {{"draw", How::kDraw}, {"erase", How::kErase}}, How::kDraw);
  act.path = fields.Path("path");
  act.depth_mm = fields.Number("depth_mm", act.depth_mm);
  act.radius_mm = fields.Number("radius_mm", act.radius_mm);
  act.rho = RhoOver(fields, act.radius_mm);
  return {act, {}, {}};
}

ClayStep AddClay(Fields& fields) {
  AddAct act;
  act.hold = Hold(fields, {"hand"});
  act.volume_mm3 = fields.NeededNumber("volume_mm3");
  return {act, {}, {}};
}

ClayStep Shave(Fields& fields) {
  ShaveAct act;
  act.hold = Hold(fields, {"hand"});
  act.depth_mm = fields.Number("depth_mm", act.depth_mm);
  return {act, {}, {}};
}

ClayStep Tear(Fields& fields) {
  TearAct act;
  act.hold = Hold(fields, {"hand", "nippers"});
  act.depth_mm = fields.Number("depth_mm", act.depth_mm);
  act.seed = fields.Count("seed", 1);
  return {act, {}, {}};
}

ClayStep SmoothClay(Fields& fields) {
  SmoothAct act;
  act.hold = Hold(fields, {"hand", "spatula"});
  act.amount = fields.Number("amount", act.amount);
  act.passes = static_cast<int>(fields.Count("passes", 3));
  return {act, {}, {}};
}

ClayStep StepOf(const JsonReader& reader, const Json& json) {
  static const std::map<std::string, std::function<ClayStep(Fields&)>> kSteps{
      {"push", [](Fields& fields) { return Push(fields, 1.0); }},
      {"pull", [](Fields& fields) { return Push(fields, -1.0); }},
      {"hole", Hole},
      {"twist", Twist},
      {"ball", Ball},
      {"spread", Spread},
      {"knead", Knead},
      {"line", Line},
      {"add", AddClay},
      {"shave", Shave},
      {"tear", Tear},
      {"smooth", SmoothClay},
      {"stretch", Stretch}};
  Fields fields(reader, json);
  std::map<std::string, std::string> names;
  for (const auto& [name, make] : kSteps) names.emplace(name, name);
  const std::string op = fields.OneOf<std::string>("op", names, "");
  if (op.empty()) throw BadStep{reader.Refuse(reader.Named("op") + " is missing").value()};
  ClayStep step = kSteps.at(op)(fields);
  step.near = fields.near();
  fields.Done();
  return step;
}

ClayPractice PracticeOf(const JsonReader& reader, const Json& root) {
  ClayPractice practice;
  if (root.contains("mirrored")) {
    if (!root.at("mirrored").is_boolean()) throw BadStep{reader.Refuse("'mirrored' is neither true nor false").value()};
    practice.mirrored = root.at("mirrored").get<bool>();
  }
  if (!root.contains("masks")) return practice;
  const auto list = reader.Array(root, "masks");
  if (!list) throw BadStep{list.error()};
  for (std::size_t n = 0; n < (*list)->size(); ++n) {
    Fields fields(reader.Within(fmt::format("masks[{}]", n)), (**list)[n]);
    ClayMask mask;
    mask.at = fields.Address();
    mask.radius_mm = fields.NeededNumber("radius_mm");
    fields.Done();
    practice.masks.push_back(mask);
  }
  return practice;
}

}  // namespace

Result<ClayScript> ClayScriptFromJson(std::string_view text, std::string_view name) {
  const JsonReader reader(name, kAdvice);
  const auto root = reader.Root(text);
  if (!root) return Fail(root);
  try {
    RETURN_IF_ERROR(reader.OnlyKeys(*root, {"operations", "mirrored", "masks"}));
    const auto list = reader.Array(*root, "operations");
    if (!list) return Fail(list);
    if ((*list)->size() > kMostSteps) {
      return reader.Refuse(fmt::format("it has {} operations, more than {}", (*list)->size(), kMostSteps));
    }
    ClayScript script;
    script.practice = PracticeOf(reader, *root);
    for (std::size_t n = 0; n < (*list)->size(); ++n) {
      script.steps.push_back(StepOf(reader.Within(fmt::format("operations[{}]", n)), (**list)[n]));
    }
    return script;
  } catch (const BadStep& bad) {
    return tl::unexpected<Error>(bad.error);
  }
}

ClayAct ActOn(const ClayBody& body, const ClayStep& step) {
  ClayAct act = step.act;
  if (step.near) {
    const ClayAddress at = ClosestAddress(body, *step.near);
    const auto hold_there = [&at](auto& one) {
      if constexpr (requires { one.hold.at; }) one.hold.at = at;
    };
    std::visit(hold_there, act);
  }
  if (!step.axis) return act;
  const auto place = [&body](const ClayEnd& end) -> Vector3d {
    if (const auto* at = std::get_if<ClayAddress>(&end)) return body.Point(*at);
    return std::get<Vector3d>(end);
  };
  const ClayAxis axis{place((*step.axis)[0]), place((*step.axis)[1])};
  if (auto* twist = std::get_if<TwistAct>(&act)) twist->axis = axis;
  if (auto* stretch = std::get_if<StretchAct>(&act)) stretch->axis = axis;
  return act;
}

Result<ClayReport> Perform(ClayBody& body, const ClayStep& step, const ClayPractice& practice) {
  if (step.axis) {
    for (const ClayEnd& end : *step.axis) {
      const auto* at = std::get_if<ClayAddress>(&end);
      if (at == nullptr) continue;
      if (at->patch < body.mesh().base_count()) {
        if (body.mesh().Locate(*at).patch != kNoIndex) continue;
        return Fail(fmt::format("perform '{}' on the clay", NameOf(step.act)),
                    fmt::format("patch {} at u {:g}, v {:g} is in a hole", at->patch, at->u, at->v),
                    "give a place on the skin");
      }
      return Fail(fmt::format("perform '{}' on the clay", NameOf(step.act)),
                  fmt::format("there is no patch {}", at->patch),
                  fmt::format("give a number below {}", body.mesh().base_count()));
    }
  }
  return Perform(body, ActOn(body, step), practice);
}

}  // namespace annulus
