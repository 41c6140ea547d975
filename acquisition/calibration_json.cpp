#include "acquisition/calibration_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "base/units.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxSensors = 65'536;
constexpr std::size_t kMaxKnots = 10'000;
constexpr Eigen::Index kMaxModes = 64;
constexpr double kMaxLengthMm = 100'000.0;

/// A number of SensorCalibration, its key, and the largest magnitude that is believed.
struct SensorField {
  const char* key;
  double SensorCalibration::*member;
  double limit;
};
constexpr std::array kSensorFields{
    SensorField{"theta_rad", &SensorCalibration::theta, 100.0},
    SensorField{"radius_mm", &SensorCalibration::radius_mm, kMaxLengthMm},
    SensorField{"range_offset_mm", &SensorCalibration::range_offset_mm, kMaxLengthMm},
    SensorField{"range_scale", &SensorCalibration::range_scale, 100.0},
    SensorField{"aim_lateral_rad", &SensorCalibration::aim_lateral, kPi},
    SensorField{"aim_vertical_rad", &SensorCalibration::aim_vertical, kPi},
    SensorField{"height_mm", &SensorCalibration::height_mm, kMaxLengthMm},
};
constexpr SensorField kQuadratic{"range_quadratic_per_mm", &SensorCalibration::range_quadratic, 1.0};

/// A number of a part of a calibration, its key, and the largest magnitude that is believed.
template <class Part>
struct PartField {
  const char* key;
  double Part::*member;
  double limit;
};
constexpr std::array kPoseFields{
    PartField<RingPose>{"x_mm", &RingPose::x_mm, kMaxLengthMm},
    PartField<RingPose>{"y_mm", &RingPose::y_mm, kMaxLengthMm},
    PartField<RingPose>{"tilt_x_rad", &RingPose::tilt_x, kPi},
    PartField<RingPose>{"tilt_y_rad", &RingPose::tilt_y, kPi},
};
constexpr std::array kCarriageFields{
    PartField<CarriagePath>{"position_scale", &CarriagePath::position_scale, 100.0},
    PartField<CarriagePath>{"slope_x", &CarriagePath::slope_x, 100.0},
    PartField<CarriagePath>{"slope_y", &CarriagePath::slope_y, 100.0},
};
constexpr std::array kUncertaintyFields{
    PartField<CalibrationUncertainty>{"distance_mm", &CalibrationUncertainty::distance_mm, kMaxLengthMm},
    PartField<CalibrationUncertainty>{"height_scale_sigma", &CalibrationUncertainty::height_scale_sigma, 100.0},
    PartField<CalibrationUncertainty>{"height_offset_sigma_mm", &CalibrationUncertainty::height_offset_sigma_mm,
                                      kMaxLengthMm},
};

tl::unexpected<std::string> Wrong(const std::string& key) {
  return tl::unexpected<std::string>("'" + key + "' is missing or wrong");
}

template <class Part, std::size_t N>
void PutFields(JsonText& json, const Part& part, const std::array<PartField<Part>, N>& fields) {
  for (const PartField<Part>& field : fields) json.Key(field.key).Number(part.*field.member);
}

/// The key that is missing or wrong; "" if none.
template <class Part, std::size_t N>
std::string TakeFields(const Json& json, Part& part, const std::array<PartField<Part>, N>& fields) {
  if (!json.is_object()) return fields[0].key;
  for (const PartField<Part>& field : fields) {
    const auto found = json.find(field.key);
    if (found == json.end() || !found->is_number()) return field.key;
    part.*field.member = found->template get<double>();
  }
  return {};
}

template <class Part, std::size_t N>
std::string CheckFields(const Part& part, const std::array<PartField<Part>, N>& fields) {
  for (const PartField<Part>& field : fields) {
    if (!(std::abs(part.*field.member) <= field.limit)) return field.key;
  }
  return {};
}

/// Numbers of an array of any length up to `most`; nothing if it is something else.
std::optional<std::vector<double>> NumbersAt(const Json& json, const char* key, std::size_t most) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array() || found->size() > most) return std::nullopt;
  std::vector<double> numbers;
  for (const Json& one : *found) {
    if (!one.is_number()) return std::nullopt;
    numbers.push_back(one.get<double>());
  }
  return numbers;
}

bool AllWithin(const std::vector<double>& numbers, double limit) {
  return std::all_of(numbers.begin(), numbers.end(), [&](double number) { return std::abs(number) <= limit; });
}

void PutCarriage(JsonText& json, const CarriagePath& carriage) {
  json.Open('{');
  PutFields(json, carriage, kCarriageFields);
  json.Key("knots_z_mm").Numbers(carriage.knots_z_mm).Key("x_mm").Numbers(carriage.x_mm);
  json.Key("y_mm").Numbers(carriage.y_mm).Close('}');
}

void PutUncertainty(JsonText& json, const CalibrationUncertainty& uncertainty) {
  json.Open('{');
  PutFields(json, uncertainty, kUncertaintyFields);
  json.Key("own_mm").Numbers(uncertainty.own_mm).Key("together_mm").Open('[');
  for (Eigen::Index mode = 0; mode < uncertainty.together_mm.cols(); ++mode) {
    json.Open('[');
    for (Eigen::Index i = 0; i < uncertainty.together_mm.rows(); ++i) json.Number(uncertainty.together_mm(i, mode));
    json.Close(']');
  }
  json.Close(']').Close('}');
}

tl::expected<CarriagePath, std::string> CarriageFromJson(const Json& json) {
  CarriagePath carriage;
  if (const std::string key = TakeFields(json, carriage, kCarriageFields); !key.empty()) return Wrong(key);
  const auto knots = NumbersAt(json, "knots_z_mm", kMaxKnots);
  const auto x = NumbersAt(json, "x_mm", kMaxKnots);
  const auto y = NumbersAt(json, "y_mm", kMaxKnots);
  if (!knots || !x || !y) return Wrong("knots_z_mm");
  carriage.knots_z_mm = *knots;
  carriage.x_mm = *x;
  carriage.y_mm = *y;
  return carriage;
}

tl::expected<CalibrationUncertainty, std::string> UncertaintyFromJson(const Json& json, std::size_t sensors) {
  CalibrationUncertainty uncertainty;
  if (const std::string key = TakeFields(json, uncertainty, kUncertaintyFields); !key.empty()) return Wrong(key);
  const auto own = NumbersAt(json, "own_mm", kMaxSensors);
  const auto together = json.find("together_mm");
  if (!own || own->size() != sensors) return Wrong("own_mm");
  if (together == json.end() || !together->is_array() || together->size() > static_cast<std::size_t>(kMaxModes)) {
    return Wrong("together_mm");
  }
  uncertainty.own_mm = *own;
  uncertainty.together_mm.resize(static_cast<Eigen::Index>(sensors), static_cast<Eigen::Index>(together->size()));
  for (std::size_t mode = 0; mode < together->size(); ++mode) {
    const Json& column = (*together)[mode];
    if (!column.is_array() || column.size() != sensors) return Wrong("together_mm");
    for (std::size_t i = 0; i < sensors; ++i) {
      if (!column[i].is_number()) return Wrong("together_mm");
      uncertainty.together_mm(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(mode)) = column[i].get<double>();
    }
  }
  return uncertainty;
}

/// The parts that older recordings do not have; "" or what is wrong.
std::string TakeParts(const Json& json, RingCalibration& calibration) {
  if (const auto pose = json.find("pose"); pose != json.end()) {
    if (std::string key = TakeFields(*pose, calibration.pose, kPoseFields); !key.empty()) return key;
  }
  if (const auto carriage = json.find("carriage"); carriage != json.end()) {
    auto taken = CarriageFromJson(*carriage);
    if (!taken) return "carriage";
    calibration.carriage = std::move(*taken);
  }
  if (const auto temperature = json.find("temperature"); temperature != json.end()) {
    constexpr std::array kTemperature{
        PartField<RingCalibration>{"reference_c", &RingCalibration::reference_c, 1000.0},
        PartField<RingCalibration>{"range_mm_per_c", &RingCalibration::range_mm_per_c, 1000.0},
    };
    if (std::string key = TakeFields(*temperature, calibration, kTemperature); !key.empty()) return key;
  }
  if (const auto certificate = json.find("certificate"); certificate != json.end()) {
    if (!certificate->is_string()) return "certificate";
    calibration.certificate = certificate->get<std::string>();
  }
  if (const auto uncertainty = json.find("uncertainty"); uncertainty != json.end()) {
    auto taken = UncertaintyFromJson(*uncertainty, calibration.sensors.size());
    if (!taken) return "uncertainty";
    calibration.uncertainty = std::move(*taken);
  }
  return {};
}

std::string CheckUncertainty(const CalibrationUncertainty& uncertainty, std::size_t sensors) {
  const std::string key = CheckFields(uncertainty, kUncertaintyFields);
  if (!key.empty()) return key;
  const bool negative =
      std::any_of(uncertainty.own_mm.begin(), uncertainty.own_mm.end(), [](double sigma) { return sigma < 0.0; });
  if (uncertainty.own_mm.size() != sensors || negative || !AllWithin(uncertainty.own_mm, kMaxLengthMm)) return "own_mm";
  if (uncertainty.height_scale_sigma < 0.0) return "height_scale_sigma";
  if (uncertainty.height_offset_sigma_mm < 0.0) return "height_offset_sigma_mm";
  const Eigen::MatrixXd& together = uncertainty.together_mm;
  if (together.cols() > kMaxModes || (together.cols() > 0 && together.rows() != static_cast<Eigen::Index>(sensors))) {
    return "together_mm";
  }
  const bool finite = together.size() == 0 || together.cwiseAbs().maxCoeff() <= kMaxLengthMm;
  return finite && together.allFinite() ? "" : "together_mm";
}

std::string CheckCarriage(const CarriagePath& carriage) {
  const std::string key = CheckFields(carriage, kCarriageFields);
  if (!key.empty()) return key;
  if (!(carriage.position_scale > 0.0)) return "position_scale";
  const std::size_t knots = carriage.knots_z_mm.size();
  const auto& z = carriage.knots_z_mm;
  const bool ascending = std::adjacent_find(z.begin(), z.end(), [](double a, double b) { return !(a < b); }) == z.end();
  if (!ascending || !AllWithin(z, kMaxLengthMm) || carriage.x_mm.size() != knots || carriage.y_mm.size() != knots ||
      !AllWithin(carriage.x_mm, kMaxLengthMm) || !AllWithin(carriage.y_mm, kMaxLengthMm)) {
    return "knots_z_mm";
  }
  return {};
}

}  // namespace

void PutCalibration(JsonText& json, const RingCalibration& calibration) {
  json.Open('{').Key("ring_serial").Text(calibration.ring_serial);
  const auto put = [&](const SensorField& field) {
    json.Key(field.key).Open('[');
    for (const SensorCalibration& sensor : calibration.sensors) json.Number(sensor.*field.member);
    json.Close(']');
  };
  for (const SensorField& field : kSensorFields) put(field);
  if (!calibration.IsPlain()) {
    put(kQuadratic);
    json.Key("pose").Open('{');
    PutFields(json, calibration.pose, kPoseFields);
    json.Close('}').Key("carriage");
    PutCarriage(json, calibration.carriage);
  }
  if (calibration.range_mm_per_c != 0.0 || calibration.reference_c != RingCalibration{}.reference_c) {
    json.Key("temperature").Open('{').Key("reference_c").Number(calibration.reference_c);
    json.Key("range_mm_per_c").Number(calibration.range_mm_per_c).Close('}');
  }
  if (!calibration.certificate.empty()) json.Key("certificate").Text(calibration.certificate);
  if (calibration.uncertainty) {
    json.Key("uncertainty");
    PutUncertainty(json, *calibration.uncertainty);
  }
  json.Close('}');
}

Json JsonFromCalibration(const RingCalibration& calibration) {
  JsonText text;
  PutCalibration(text, calibration);
  return Json::parse(text.Take());
}

tl::expected<RingCalibration, std::string> CalibrationFromJson(const Json& json) {
  if (!json.is_object()) return Wrong("calibration");
  const auto serial = json.find("ring_serial");
  if (serial == json.end() || !serial->is_string()) return Wrong("ring_serial");
  const auto first = json.find(kSensorFields[0].key);
  if (first == json.end() || !first->is_array() || first->size() > kMaxSensors) return Wrong(kSensorFields[0].key);
  RingCalibration calibration;
  calibration.ring_serial = serial->get<std::string>();
  calibration.sensors.resize(first->size());
  const auto take = [&](const SensorField& field) {
    const auto numbers = NumbersAt(json, field.key, kMaxSensors);
    if (!numbers || numbers->size() != calibration.sensors.size()) return false;
    for (std::size_t i = 0; i < numbers->size(); ++i) calibration.sensors[i].*field.member = (*numbers)[i];
    return true;
  };
  for (const SensorField& field : kSensorFields) {
    if (!take(field)) return Wrong(field.key);
  }
  if (json.contains(kQuadratic.key) && !take(kQuadratic)) return Wrong(kQuadratic.key);
  if (const std::string wrong = TakeParts(json, calibration); !wrong.empty()) return Wrong(wrong);
  if (const auto checked = CheckCalibration(calibration); !checked) return tl::unexpected<std::string>(checked.error());
  return calibration;
}

tl::expected<void, std::string> CheckCalibration(const RingCalibration& calibration) {
  const auto& sensors = calibration.sensors;
  if (sensors.empty() || sensors.size() > kMaxSensors) return Wrong("calibration");
  for (const SensorCalibration& sensor : sensors) {
    for (const SensorField& field : kSensorFields) {
      if (!(std::abs(sensor.*field.member) <= field.limit)) return Wrong(field.key);
    }
    if (!(std::abs(sensor.range_quadratic) <= kQuadratic.limit)) return Wrong(kQuadratic.key);
    if (sensor.radius_mm <= 0.0) return Wrong("radius_mm");
    if (!(sensor.range_scale > 0.0)) return Wrong("range_scale");
  }
  if (const std::string key = CheckFields(calibration.pose, kPoseFields); !key.empty()) return Wrong(key);
  if (const std::string key = CheckCarriage(calibration.carriage); !key.empty()) return Wrong(key);
  if (!(std::abs(calibration.reference_c) <= 1000.0)) return Wrong("reference_c");
  if (!(std::abs(calibration.range_mm_per_c) <= 1000.0)) return Wrong("range_mm_per_c");
  if (calibration.uncertainty) {
    const std::string key = CheckUncertainty(*calibration.uncertainty, sensors.size());
    if (!key.empty()) return Wrong(key);
  }
  return {};
}

}  // namespace annulus
