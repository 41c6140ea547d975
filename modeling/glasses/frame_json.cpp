#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "modeling/glasses/frame_parameters.h"
#include "modeling/glasses/placement.h"

namespace annulus {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr const char* kFrameFormat = "annulus-frame";
constexpr const char* kWornFormat = "annulus-worn";
constexpr int kVersion = 1;

/// Reads typed members of one file and words every failure alike.
class Reader {
 public:
  Reader(std::string_view name, const char* advice) : attempt_(fmt::format("read {}", name)), advice_(advice) {}

  [[nodiscard]] tl::unexpected<Error> Refuse(std::string seen) const {
    return Fail(attempt_, std::move(seen), advice_);
  }

  /// The root object, of our format and version.
  [[nodiscard]] Result<Json> Root(std::string_view text, const char* format) const {
    Json root = Json::parse(text, nullptr, false);
    if (root.is_discarded() || !root.is_object()) return Refuse("it is not a complete JSON object");
    if (root.value("format", Json()) != format) return Refuse(fmt::format("its format is not '{}'", format));
    if (root.value("version", Json()) != kVersion) return Refuse(fmt::format("its version is not {}", kVersion));
    return root;
  }

  [[nodiscard]] Result<Json> Object(const Json& parent, std::string_view key) const {
    const auto found = parent.find(key);
    if (found == parent.end() || !found->is_object()) return Refuse(fmt::format("'{}' is missing or no object", key));
    return *found;
  }

  [[nodiscard]] Result<double> Number(const Json& parent, std::string_view key) const {
    const auto found = parent.find(key);
    if (found == parent.end() || !found->is_number()) return Refuse(fmt::format("'{}' is missing or no number", key));
    const auto value = found->get<double>();
    if (!std::isfinite(value)) return Refuse(fmt::format("'{}' is too large", key));
    return value;
  }

  [[nodiscard]] Result<Eigen::Vector3d> Vector(const Json& array, std::string_view key) const {
    if (!array.is_array() || array.size() != 3) return Refuse(fmt::format("'{}' is not three numbers", key));
    Eigen::Vector3d vector;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!array[axis].is_number() || !std::isfinite(array[axis].get<double>())) {
        return Refuse(fmt::format("'{}' is not three numbers", key));
      }
      vector[static_cast<Eigen::Index>(axis)] = array[axis].get<double>();
    }
    return vector;
  }

 private:
  std::string attempt_;
  const char* advice_;
};

constexpr const char* kFrameAdvice = "make it again with annulus glasses design";
constexpr const char* kWornAdvice = "make it again with annulus glasses fit";

OrderedJson ToJson(const Eigen::Vector3d& v) { return OrderedJson::array({v.x(), v.y(), v.z()}); }

OrderedJson ToJson(const FrameParameters& parameters) {
  OrderedJson json = OrderedJson::object();
  for (const FrameParameterField& field : FrameParameterFields())
    json[std::string(field.key)] = parameters.*field.member;
  return json;
}

Result<FrameParameters> ReadParameters(const Reader& reader, const Json& root) {
  const Result<Json> object = reader.Object(root, "parameters");
  RETURN_IF_ERROR(object);
  FrameParameters parameters;
  for (const FrameParameterField& field : FrameParameterFields()) {
    const Result<double> value = reader.Number(*object, field.key);
    RETURN_IF_ERROR(value);
    parameters.*field.member = *value;
  }
  if (const Status valid = Validate(parameters); !valid) return reader.Refuse(valid.error().seen);
  return parameters;
}

OrderedJson ToJson(const Eigen::Isometry3d& station_from_frame) {
  OrderedJson rows = OrderedJson::array();
  for (Eigen::Index row = 0; row < 3; ++row) rows.push_back(ToJson(station_from_frame.linear().row(row)));
  return {{"rotation", rows}, {"translation_mm", ToJson(Eigen::Vector3d(station_from_frame.translation()))}};
}

Result<Eigen::Isometry3d> ReadTransform(const Reader& reader, const Json& root) {
  const Result<Json> object = reader.Object(root, "station_from_frame");
  RETURN_IF_ERROR(object);
  const Json rows = object->value("rotation", Json());
  if (!rows.is_array() || rows.size() != 3) return reader.Refuse("'rotation' is not three rows");
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  for (std::size_t row = 0; row < 3; ++row) {
    const Result<Eigen::Vector3d> values = reader.Vector(rows[row], "rotation");
    RETURN_IF_ERROR(values);
    transform.linear().row(static_cast<Eigen::Index>(row)) = values->transpose();
  }
  const Eigen::Matrix3d product = transform.linear() * transform.linear().transpose();
  if (!product.isIdentity(1e-6) || transform.linear().determinant() < 0.0) {
    return reader.Refuse("'rotation' is no rotation");
  }
  const Result<Eigen::Vector3d> translation = reader.Vector(object->value("translation_mm", Json()), "translation_mm");
  RETURN_IF_ERROR(translation);
  transform.translation() = *translation;
  return transform;
}

OrderedJson ToJson(const FacePoints& face) {
  OrderedJson json = OrderedJson::object();
  for (const NamedFacePoint& point : FacePointNames()) {
    const FacePoint& value = face.*point.member;
    json[std::string(point.name)] = {{"position_mm", ToJson(value.position)},
                                     {"source", LandmarkSourceName(value.source)}};
  }
  return json;
}

Result<LandmarkSource> ReadSource(const Reader& reader, const Json& text) {
  for (const LandmarkSource source : {LandmarkSource::kDetected, LandmarkSource::kProportion, LandmarkSource::kGiven}) {
    if (text.is_string() && text.get_ref<const std::string&>() == LandmarkSourceName(source)) return source;
  }
  return reader.Refuse("a face point's 'source' is unknown");
}

Result<FacePoints> ReadFace(const Reader& reader, const Json& root) {
  const Result<Json> object = reader.Object(root, "face_points");
  RETURN_IF_ERROR(object);
  FacePoints face;
  for (const NamedFacePoint& point : FacePointNames()) {
    const Result<Json> entry = reader.Object(*object, point.name);
    RETURN_IF_ERROR(entry);
    const Result<Eigen::Vector3d> position = reader.Vector(entry->value("position_mm", Json()), point.name);
    RETURN_IF_ERROR(position);
    const Result<LandmarkSource> source = ReadSource(reader, entry->value("source", Json()));
    RETURN_IF_ERROR(source);
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

Status ReadNumbers(const Reader& reader, const Json& root, WornFrame& worn) {
  for (const WornNumber& number : kWornNumbers) {
    const Result<double> value = reader.Number(root, number.key);
    RETURN_IF_ERROR(value);
    worn.*number.member = *value;
  }
  const Result<Json> residuals = reader.Object(root, "residuals");
  RETURN_IF_ERROR(residuals);
  for (const ResidualNumber& number : kResiduals) {
    const Result<double> value = reader.Number(*residuals, number.key);
    RETURN_IF_ERROR(value);
    worn.residuals.*number.member = *value;
  }
  return {};
}

}  // namespace

std::string FrameParametersToJson(const FrameParameters& parameters, std::string_view style) {
  const OrderedJson root{
      {"format", kFrameFormat}, {"version", kVersion}, {"style", style}, {"parameters", ToJson(parameters)}};
  return root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<FrameParameters> FrameParametersFromJson(std::string_view json, std::string_view name) {
  const Reader reader(name, kFrameAdvice);
  const Result<Json> root = reader.Root(json, kFrameFormat);
  RETURN_IF_ERROR(root);
  return ReadParameters(reader, *root);
}

std::string WornFrameToJson(const WornFrame& worn) {
  OrderedJson root{
      {"format", kWornFormat},
      {"version", kVersion},
      {"parameters", ToJson(worn.design.parameters)},
      {"station_from_frame", ToJson(worn.station_from_frame)},
      {"ears_in_frame_mm",
       {{"right", ToJson(worn.adjustment.temple_right.ear)}, {"left", ToJson(worn.adjustment.temple_left.ear)}}},
      {"face_points", ToJson(worn.face)},
      {"tilt_rad", worn.tilt},
      {"tilt_deg", DegreesFromRadians(worn.tilt)}};
  for (const WornNumber& number : kWornNumbers) root[number.key] = worn.*number.member;
  for (const ResidualNumber& number : kResiduals) root["residuals"][number.key] = worn.residuals.*number.member;
  return root.dump(2) + "\n";
}

Result<WornFrame> WornFrameFromJson(std::string_view json, std::string_view name) {
  const Reader reader(name, kWornAdvice);
  const Result<Json> root = reader.Root(json, kWornFormat);
  RETURN_IF_ERROR(root);
  const Result<FrameParameters> parameters = ReadParameters(reader, *root);
  RETURN_IF_ERROR(parameters);
  const Result<Eigen::Isometry3d> transform = ReadTransform(reader, *root);
  RETURN_IF_ERROR(transform);
  const Result<FacePoints> face = ReadFace(reader, *root);
  RETURN_IF_ERROR(face);
  const Result<Json> ears = reader.Object(*root, "ears_in_frame_mm");
  RETURN_IF_ERROR(ears);
  const Result<Eigen::Vector3d> ear_right = reader.Vector(ears->value("right", Json()), "ears_in_frame_mm");
  RETURN_IF_ERROR(ear_right);
  const Result<Eigen::Vector3d> ear_left = reader.Vector(ears->value("left", Json()), "ears_in_frame_mm");
  RETURN_IF_ERROR(ear_left);
  const Result<double> tilt = reader.Number(*root, "tilt_rad");
  RETURN_IF_ERROR(tilt);

  WornFrame worn;
  worn.design = *parameters;
  worn.adjustment = StandardAdjustment(worn.design);
  worn.station_from_frame = *transform;
  worn.face = *face;
  worn.adjustment.temple_right.ear = *ear_right;
  worn.adjustment.temple_left.ear = *ear_left;
  worn.tilt = *tilt;
  RETURN_IF_ERROR(ReadNumbers(reader, *root, worn));
  const Result<Frame> frame = BuildWornFrame(worn);
  if (!frame) return reader.Refuse(frame.error().seen);
  return worn;
}

}  // namespace annulus
