#include "modeling/glasses/design_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "modeling/glasses/frame_fields.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

/// "face_form" of "face_form_deg".
std::string_view StemOf(const FrameField& field) {
  constexpr std::string_view kSuffix = "_deg";
  return field.key.substr(0, field.key.size() - kSuffix.size());
}

void PutField(Json& object, const FrameField& field, const FrameDesign& design) {
  if (field.unit == FieldUnit::kWord) {
    object[std::string(field.key)] = FormWord(field, design);
    return;
  }
  const std::optional<double> number = StoredNumber(field, design);
  if (!number) return;
  if (field.unit == FieldUnit::kDegrees) {
    PutAngle(object, StemOf(field), *number);
  } else {
    object[std::string(field.key)] = *number;
  }
}

bool IsDefault(const FrameField& field, const FrameDesign& design) {
  const FrameDesign paper;
  if (field.unit == FieldUnit::kWord) return FormWord(field, design) == FormWord(field, paper);
  return StoredNumber(field, design) == StoredNumber(field, paper);
}

Result<FrameDesign> ReadDetail(const JsonReader& reader, const Json& object, const std::string& key,
                               const FrameDesign& design) {
  for (const FrameField& field : FrameFields()) {
    if (IsParameter(field)) continue;
    if (field.unit == FieldUnit::kWord && key == field.key) {
      const Result<std::string> word = reader.Text(object, key);
      if (!word) return Fail(word);
      if (auto changed = WithFormWord(field, design, *word)) return *std::move(changed);
      return reader.Refuse(
          fmt::format("{} is '{}', not one of {}", reader.Named(key), *word, fmt::join(FormWords(field), ", ")));
    }
    if (field.unit == FieldUnit::kDegrees && (key == field.key || key == fmt::format("{}_rad", StemOf(field)))) {
      const Result<double> angle = reader.Angle(object, StemOf(field));
      if (!angle) return Fail(angle);
      return WithStoredNumber(field, design, *angle);
    }
    if (key == field.key) {
      const Result<double> number = reader.Number(object, key);
      if (!number) return Fail(number);
      return WithStoredNumber(field, design, *number);
    }
  }
  return reader.Refuse(fmt::format("there is no key {}", reader.Named(key)));
}

Result<FrameDesign> ReadParameters(const JsonReader& reader, const Json& object) {
  FrameDesign design;
  for (const FrameField& field : FrameFields()) {
    if (!IsParameter(field)) continue;
    const Result<double> value = reader.Number(object, field.key);
    if (!value) return Fail(value);
    design = WithStoredNumber(field, design, *value);
  }
  for (const auto& [key, value] : object.items()) {
    const auto known = [&k = key](const FrameField& field) { return IsParameter(field) && field.key == k; };
    if (std::none_of(FrameFields().begin(), FrameFields().end(), known)) {
      return reader.Refuse(fmt::format("there is no key {}", reader.Named(key)));
    }
  }
  return design;
}

struct NamedTemple {
  const char* key;
  TempleShape FrameAdjustment::*member;
};
constexpr std::array<NamedTemple, 2> kTemples{
    {{"temple_right", &FrameAdjustment::temple_right}, {"temple_left", &FrameAdjustment::temple_left}}};
struct NamedPad {
  const char* key;
  PadPose FrameAdjustment::*member;
};
constexpr std::array<NamedPad, 2> kPads{
    {{"pad_right", &FrameAdjustment::pad_right}, {"pad_left", &FrameAdjustment::pad_left}}};

Result<TempleShape> ReadTemple(const JsonReader& reader, const Json& object) {
  RETURN_IF_ERROR(reader.OnlyKeys(object, {"ear_mm", "bow_deg", "bow_rad", "tip_in_deg", "tip_in_rad"}));
  const Result<Eigen::Vector3d> ear = reader.Vector(object, "ear_mm");
  if (!ear) return Fail(ear);
  const Result<double> bow = reader.Angle(object, "bow");
  if (!bow) return Fail(bow);
  const Result<double> tip_in = reader.Angle(object, "tip_in");
  if (!tip_in) return Fail(tip_in);
  return TempleShape{*ear, *bow, *tip_in};
}

Result<PadPose> ReadPad(const JsonReader& reader, const Json& object) {
  RETURN_IF_ERROR(reader.OnlyKeys(object, {"centre_mm", "normal", "up"}));
  const Result<Eigen::Vector3d> centre = reader.Vector(object, "centre_mm");
  if (!centre) return Fail(centre);
  const Result<Eigen::Vector3d> normal = reader.Vector(object, "normal");
  if (!normal) return Fail(normal);
  const Result<Eigen::Vector3d> up = reader.Vector(object, "up");
  if (!up) return Fail(up);
  constexpr double kUnitTolerance = 1e-6;
  if (!(std::abs(normal->norm() - 1.0) < kUnitTolerance) || !(std::abs(up->norm() - 1.0) < kUnitTolerance) ||
      !(std::abs(normal->dot(*up)) < kUnitTolerance)) {
    return reader.Refuse(
        fmt::format("{} and {} are not perpendicular unit vectors", reader.Named("normal"), reader.Named("up")));
  }
  return PadPose{*centre, *normal, *up};
}

}  // namespace

void PutDesign(Json& object, const FrameDesign& design, std::optional<DesignMaterial> material) {
  if (!design.style.empty()) object["style"] = design.style;
  if (material) object["material"] = DesignMaterialWord(*material);
  Json& parameters = object["parameters"] = Json::object();
  // In the paper's order.
  for (const FrameParameterField& field : FrameParameterFields()) {
    parameters[std::string(field.key)] = design.parameters.*field.member;
  }
  Json details = Json::object();
  for (const FrameField& field : FrameFields()) {
    if (!IsParameter(field) && !IsDefault(field, design)) PutField(details, field, design);
  }
  if (!details.empty()) object["details"] = std::move(details);
}

Result<FrameDesign> ReadDesign(const JsonReader& reader, const Json& object) {
  const Result<const Json*> parameters = reader.Object(object, "parameters");
  if (!parameters) return Fail(parameters);
  Result<FrameDesign> design = ReadParameters(reader.Within("parameters"), **parameters);
  if (!design) return Fail(design);
  if (object.contains("details")) {
    const Result<const Json*> details = reader.Object(object, "details");
    if (!details) return Fail(details);
    const JsonReader inside = reader.Within("details");
    for (const auto& [key, value] : (*details)->items()) {
      design = ReadDetail(inside, **details, key, *design);
      if (!design) return Fail(design);
    }
  }
  if (const Status valid = Validate(*design); !valid) return reader.Refuse(valid.error().seen);
  return design;
}

Result<std::optional<DesignMaterial>> ReadMaterial(const JsonReader& reader, const Json& object) {
  if (!object.contains("material")) return std::optional<DesignMaterial>();
  const Result<std::string> word = reader.Text(object, "material");
  if (!word) return Fail(word);
  for (std::size_t k = 0; k < kDesignMaterialWords.size(); ++k) {
    if (*word == kDesignMaterialWords[k]) return std::optional(static_cast<DesignMaterial>(k));
  }
  return reader.Refuse(
      fmt::format("{} is '{}', not one of {}", reader.Named("material"), *word, fmt::join(kDesignMaterialWords, ", ")));
}

Json AdjustmentToJson(const FrameAdjustment& adjustment) {
  Json json = Json::object();
  for (const NamedTemple& temple : kTemples) {
    const TempleShape& shape = adjustment.*temple.member;
    Json& object = json[temple.key] = {{"ear_mm", JsonOf(shape.ear)}};
    PutAngle(object, "bow", shape.bow);
    PutAngle(object, "tip_in", shape.tip_in);
  }
  for (const NamedPad& pad : kPads) {
    const PadPose& pose = adjustment.*pad.member;
    json[pad.key] = {{"centre_mm", JsonOf(pose.centre)}, {"normal", JsonOf(pose.normal)}, {"up", JsonOf(pose.up)}};
  }
  return json;
}

Result<FrameAdjustment> ReadAdjustment(const JsonReader& reader, const Json& parent) {
  const Result<const Json*> object = reader.Object(parent, "adjustment");
  if (!object) return Fail(object);
  const JsonReader inside = reader.Within("adjustment");
  RETURN_IF_ERROR(inside.OnlyKeys(**object, {"temple_right", "temple_left", "pad_right", "pad_left"}));
  FrameAdjustment adjustment;
  for (const NamedTemple& temple : kTemples) {
    const Result<const Json*> entry = inside.Object(**object, temple.key);
    if (!entry) return Fail(entry);
    const Result<TempleShape> shape = ReadTemple(inside.Within(temple.key), **entry);
    if (!shape) return Fail(shape);
    adjustment.*temple.member = *shape;
  }
  for (const NamedPad& pad : kPads) {
    const Result<const Json*> entry = inside.Object(**object, pad.key);
    if (!entry) return Fail(entry);
    const Result<PadPose> pose = ReadPad(inside.Within(pad.key), **entry);
    if (!pose) return Fail(pose);
    adjustment.*pad.member = *pose;
  }
  return adjustment;
}

}  // namespace annulus
