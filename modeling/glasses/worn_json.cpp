#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/ensure.h"
#include "modeling/glasses/design_json.h"
#include "modeling/glasses/frame_json.h"
#include "modeling/glasses/json_reader.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "annulus-worn";
constexpr int kVersion = 2;
constexpr const char* kAdvice = "make it again with annulus glasses fit";

Json ToJson(const Eigen::Isometry3d& station_from_frame) {
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < 3; ++row) rows.push_back(JsonOf(station_from_frame.linear().row(row)));
  return {{"rotation", rows}, {"translation_mm", JsonOf(station_from_frame.translation())}};
}

Result<Eigen::Isometry3d> ReadTransform(const JsonReader& reader, const Json& root) {
  const Result<const Json*> object = reader.Object(root, "station_from_frame");
  if (!object) return Fail(object);
  const JsonReader inside = reader.Within("station_from_frame");
  RETURN_IF_ERROR(inside.OnlyKeys(**object, {"rotation", "translation_mm"}));
  const Result<const Json*> rows = inside.Array(**object, "rotation");
  if (!rows) return Fail(rows);
  if ((*rows)->size() != 3) return reader.Refuse(inside.Named("rotation") + " is not three rows");
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  for (std::size_t row = 0; row < 3; ++row) {
    const auto values = VectorOf((**rows)[row]);
    if (!values) return reader.Refuse(inside.Named("rotation") + " is not three rows of three numbers");
    transform.linear().row(static_cast<Eigen::Index>(row)) = values->transpose();
  }
  const Eigen::Matrix3d product = transform.linear() * transform.linear().transpose();
  if (!product.isIdentity(1e-6) || transform.linear().determinant() < 0.0) {
    return reader.Refuse(inside.Named("rotation") + " is no rotation");
  }
  const Result<Eigen::Vector3d> translation = inside.Vector(**object, "translation_mm");
  if (!translation) return Fail(translation);
  transform.translation() = *translation;
  return transform;
}

Json ToJson(const FacePoints& face) {
  Json json = Json::object();
  for (const NamedFacePoint& point : FacePointNames()) {
    const FacePoint& value = face.*point.member;
    json[std::string(point.name)] = {{"position_mm", JsonOf(value.position)},
                                     {"source", LandmarkSourceName(value.source)}};
  }
  return json;
}

Result<LandmarkSource> ReadSource(const JsonReader& reader, const Json& entry) {
  const Result<std::string> text = reader.Text(entry, "source");
  if (!text) return Fail(text);
  for (const LandmarkSource source : {LandmarkSource::kDetected, LandmarkSource::kProportion, LandmarkSource::kGiven}) {
    if (*text == LandmarkSourceName(source)) return source;
  }
  return reader.Refuse(fmt::format("{} is unknown", reader.Named("source")));
}

Result<FacePoints> ReadFace(const JsonReader& reader, const Json& root) {
  const Result<const Json*> object = reader.Object(root, "face_points");
  if (!object) return Fail(object);
  const JsonReader inside = reader.Within("face_points");
  FacePoints face;
  for (const NamedFacePoint& point : FacePointNames()) {
    const Result<const Json*> entry = inside.Object(**object, point.name);
    if (!entry) return Fail(entry);
    const JsonReader at_point = inside.Within(point.name);
    const Result<Eigen::Vector3d> position = at_point.Vector(**entry, "position_mm");
    if (!position) return Fail(position);
    const Result<LandmarkSource> source = ReadSource(at_point, **entry);
    if (!source) return Fail(source);
    face.*point.member = {*position, *source};
  }
  return face;
}

/// A number of WORN.json and the member that holds it.
struct WornNumber {
  const char* key;
  double WornFrame::*member;
};
constexpr std::array<WornNumber, 4> kWornNumbers{{{"forward_shift_mm", &WornFrame::forward_shift},
                                                  {"clearance_mm", &WornFrame::clearance},
                                                  {"l6_right_mm", &WornFrame::l6_right},
                                                  {"l6_left_mm", &WornFrame::l6_left}}};
struct ResidualNumber {
  const char* key;
  double PlacementResiduals::*member;
};
constexpr std::array<ResidualNumber, 5> kResiduals{{{"eye_right_mm", &PlacementResiduals::eye_right},
                                                    {"eye_left_mm", &PlacementResiduals::eye_left},
                                                    {"bridge_mm", &PlacementResiduals::bridge},
                                                    {"ear_right_mm", &PlacementResiduals::ear_right},
                                                    {"ear_left_mm", &PlacementResiduals::ear_left}}};

Status ReadNumbers(const JsonReader& reader, const Json& root, WornFrame& worn) {
  for (const WornNumber& number : kWornNumbers) {
    const Result<double> value = reader.Number(root, number.key);
    if (!value) return Fail(value);
    worn.*number.member = *value;
  }
  const Result<const Json*> residuals = reader.Object(root, "residuals");
  if (!residuals) return Fail(residuals);
  const JsonReader inside = reader.Within("residuals");
  for (const ResidualNumber& number : kResiduals) {
    const Result<double> value = inside.Number(**residuals, number.key);
    if (!value) return Fail(value);
    worn.residuals.*number.member = *value;
  }
  return {};
}

/// Version 1: the paper's frame, and of its adjustment the ears.
Status ReadVersion1Design(const JsonReader& reader, const Json& root, WornFile& file) {
  RETURN_IF_ERROR(reader.OnlyKeys(
      root, {"format", "version", "parameters", "station_from_frame", "ears_in_frame_mm", "face_points", "tilt_rad",
             "tilt_deg", "forward_shift_mm", "clearance_mm", "l6_right_mm", "l6_left_mm", "residuals"}));
  const Result<FrameDesign> design = ReadDesign(reader, root);
  if (!design) return Fail(design);
  const Result<const Json*> ears = reader.Object(root, "ears_in_frame_mm");
  if (!ears) return Fail(ears);
  const JsonReader inside = reader.Within("ears_in_frame_mm");
  const Result<Eigen::Vector3d> right = inside.Vector(**ears, "right");
  if (!right) return Fail(right);
  const Result<Eigen::Vector3d> left = inside.Vector(**ears, "left");
  if (!left) return Fail(left);
  const Result<double> tilt = reader.Number(root, "tilt_rad");  // "tilt_deg" beside it is for reading
  if (!tilt) return Fail(tilt);
  file.worn.tilt = *tilt;
  file.worn.design = *design;
  file.worn.adjustment = StandardAdjustment(*design);
  file.worn.adjustment.temple_right.ear = *right;
  file.worn.adjustment.temple_left.ear = *left;
  return {};
}

Status ReadSections(const JsonReader& reader, const Json& root, WornFile& file) {
  if (!root.contains("sections")) return {};
  const Result<const Json*> sections = reader.Object(root, "sections");
  if (!sections) return Fail(sections);
  for (const auto& [name, value] : (*sections)->items()) {
    if (!value.is_object()) return reader.Refuse(reader.Within("sections").Named(name) + " is no object");
    file.sections.push_back({name, value.dump()});
  }
  return {};
}

Status ReadVersion2Design(const JsonReader& reader, const Json& root, WornFile& file) {
  RETURN_IF_ERROR(reader.OnlyKeys(
      root, {"format", "version", "design", "adjustment", "station_from_frame", "face_points", "tilt_deg", "tilt_rad",
             "forward_shift_mm", "clearance_mm", "l6_right_mm", "l6_left_mm", "residuals", "sections"}));
  const Result<const Json*> object = reader.Object(root, "design");
  if (!object) return Fail(object);
  const JsonReader inside = reader.Within("design");
  RETURN_IF_ERROR(inside.OnlyKeys(**object, {"style", "material", "parameters", "details"}));
  const Result<FrameDesign> design = ReadDesign(inside, **object);
  if (!design) return Fail(design);
  file.worn.design = *design;
  if ((*object)->contains("style")) {
    const Result<std::string> style = inside.Text(**object, "style");
    if (!style) return Fail(style);
    file.worn.design.style = *style;
  }
  const auto material = ReadMaterial(inside, **object);
  if (!material) return Fail(material);
  file.material = *material;
  const Result<FrameAdjustment> adjustment = ReadAdjustment(reader, root);
  if (!adjustment) return Fail(adjustment);
  file.worn.adjustment = *adjustment;
  const Result<double> tilt = reader.Angle(root, "tilt");
  if (!tilt) return Fail(tilt);
  file.worn.tilt = *tilt;
  return ReadSections(reader, root, file);
}

}  // namespace

std::string_view WornFile::Section(std::string_view name) const {
  for (const WornSection& section : sections) {
    if (section.name == name) return section.json;
  }
  return {};
}

void WornFile::SetSection(std::string_view name, std::string_view json) {
  ENSURE(Json::parse(json, nullptr, false).is_object(), "a section is a JSON object");
  for (WornSection& section : sections) {
    if (section.name != name) continue;
    section.json = json;
    return;
  }
  sections.push_back({std::string(name), std::string(json)});
}

std::string WornFileToJson(const WornFile& file) {
  const WornFrame& worn = file.worn;
  Json root{{"format", kFormat}, {"version", kVersion}, {"design", Json::object()}};
  PutDesign(root["design"], worn.design, file.material);
  root["adjustment"] = AdjustmentToJson(worn.adjustment);
  root["station_from_frame"] = ToJson(worn.station_from_frame);
  root["face_points"] = ToJson(worn.face);
  PutAngle(root, "tilt", worn.tilt);
  for (const WornNumber& number : kWornNumbers) root[number.key] = worn.*number.member;
  for (const ResidualNumber& number : kResiduals) root["residuals"][number.key] = worn.residuals.*number.member;
  for (const WornSection& section : file.sections) root["sections"][section.name] = Json::parse(section.json);
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<WornFile> WornFileFromJson(std::string_view json, std::string_view name) {
  const JsonReader reader(name, kAdvice);
  const Result<Json> root = reader.Root(json);
  if (!root) return Fail(root);
  const Result<int> version = reader.Version(*root, kFormat, kVersion);
  if (!version) return Fail(version);
  WornFile file;
  RETURN_IF_ERROR(*version == 1 ? ReadVersion1Design(reader, *root, file) : ReadVersion2Design(reader, *root, file));
  const Result<Eigen::Isometry3d> transform = ReadTransform(reader, *root);
  if (!transform) return Fail(transform);
  file.worn.station_from_frame = *transform;
  const Result<FacePoints> face = ReadFace(reader, *root);
  if (!face) return Fail(face);
  file.worn.face = *face;
  RETURN_IF_ERROR(ReadNumbers(reader, *root, file.worn));
  const Result<Frame> frame = BuildWornFrame(file.worn);
  if (!frame) return reader.Refuse(frame.error().seen);
  return file;
}

std::string WornFrameToJson(const WornFrame& worn) { return WornFileToJson({worn, {}, {}}); }

Result<WornFrame> WornFrameFromJson(std::string_view json, std::string_view name) {
  const Result<WornFile> file = WornFileFromJson(json, name);
  if (!file) return Fail(file);
  return file->worn;
}

}  // namespace annulus
