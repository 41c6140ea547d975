#include "modeling/exchange/systematic_json.h"

#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "modeling/exchange/base64.h"
#include "modeling/exchange/json_fields.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kCalibration = "calibration_covariance";
constexpr const char* kSway = "sway";

CalibrationErrors CalibrationFromJson(const Json& json) {
  const std::size_t n = Count(json, "directions", 1, CalibrationErrors::kMaxDirections);
  const std::size_t entries = n * (n + 1) / 2;
  const auto bytes = DecodeBase64(String(json, "offset_covariance_mm2"));
  if (!bytes || bytes->size() != entries * sizeof(double)) {
    throw BadModel{"'offset_covariance_mm2' does not hold " + std::to_string(entries) + " entries"};
  }
  std::vector<double> lower(entries);
  std::memcpy(lower.data(), bytes->data(), bytes->size());
  CalibrationErrors errors;
  const auto size = static_cast<Eigen::Index>(n);
  errors.offset_covariance.resize(size, size);
  std::size_t next = 0;
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      errors.offset_covariance(i, j) = lower[next];
      errors.offset_covariance(j, i) = lower[next++];
    }
  }
  errors.height_scale_sigma = Number(json, "height_scale_sigma");
  errors.height_offset_sigma = Number(json, "height_offset_sigma_mm");
  return errors;
}

SwayErrors SwayFromJson(const Json& json) {
  return {Number(json, "sigma_x_mm"), Number(json, "sigma_y_mm"), Number(json, "correlation_length_mm")};
}

bool Has(const Json& model, const char* key) {
  const auto found = model.find(key);
  return found != model.end() && !found->is_null();
}

}  // namespace

Json CalibrationToJson(const std::optional<SystematicErrors>& errors) {
  if (!errors || !errors->calibration) return nullptr;
  const Eigen::MatrixXd& covariance = errors->calibration->offset_covariance;
  std::vector<double> lower;
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) lower.push_back(covariance(i, j));
  }
  Json json;
  json["directions"] = covariance.rows();
  json["encoding"] = "base64 little-endian float64: rows of the lower triangle";
  json["offset_covariance_mm2"] = EncodeBase64(std::as_bytes(std::span(lower)));
  json["height_scale_sigma"] = errors->calibration->height_scale_sigma;
  json["height_offset_sigma_mm"] = errors->calibration->height_offset_sigma;
  return json;
}

Json SwayToJson(const std::optional<SystematicErrors>& errors) {
  if (!errors || !errors->sway) return nullptr;
  return {{"sigma_x_mm", errors->sway->sigma_x},
          {"sigma_y_mm", errors->sway->sigma_y},
          {"correlation_length_mm", errors->sway->correlation_length}};
}

std::optional<SystematicErrors> SystematicFromJson(const Json& model) {
  SystematicErrors errors;
  if (Has(model, kCalibration)) errors.calibration = CalibrationFromJson(model[kCalibration]);
  if (Has(model, kSway)) errors.sway = SwayFromJson(model[kSway]);
  if (!errors.calibration && !errors.sway) return std::nullopt;
  const Status checked = CheckSystematicErrors(errors);
  if (!checked) throw BadModel{checked.error().seen};
  return errors;
}

}  // namespace annulus
