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
constexpr const char* kEncoding = "base64 little-endian float64: rows of the lower triangle";

/// The symmetric matrix of `size` rows whose lower triangle is the value of `key`.
Eigen::MatrixXd SymmetricFromJson(const Json& json, const char* key, std::size_t size) {
  const std::size_t entries = size * (size + 1) / 2;
  const auto bytes = DecodeBase64(String(json, key));
  if (!bytes || bytes->size() != entries * sizeof(double)) {
    throw BadModel{"'" + std::string(key) + "' does not hold " + std::to_string(entries) + " entries"};
  }
  std::vector<double> lower(entries);
  std::memcpy(lower.data(), bytes->data(), bytes->size());
  const auto rows = static_cast<Eigen::Index>(size);
  Eigen::MatrixXd matrix(rows, rows);
  std::size_t next = 0;
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) {
      matrix(i, j) = lower[next];
      matrix(j, i) = lower[next++];
    }
  }
  return matrix;
}

std::string LowerTriangle(const Eigen::MatrixXd& matrix) {
  std::vector<double> lower;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) lower.push_back(matrix(i, j));
  }
  return EncodeBase64(std::as_bytes(std::span(lower)));
}

CalibrationErrors CalibrationFromJson(const Json& json) {
  CalibrationErrors errors;
  const std::size_t n = Count(json, "directions", 1, CalibrationErrors::kMaxDirections);
  errors.offset_covariance = SymmetricFromJson(json, "offset_covariance_mm2", n);
  errors.height_scale_sigma = Number(json, "height_scale_sigma");
  errors.height_offset_sigma = Number(json, "height_offset_sigma_mm");
  return errors;
}

SwayErrors SwayFromJson(const Json& json) {
  SwayErrors sway{
      Number(json, "sigma_x_mm"), Number(json, "sigma_y_mm"), Number(json, "correlation_length_mm"), {}, {}};
  const auto heights = json.find("heights_mm");
  if (heights == json.end() || heights->is_null()) return sway;
  sway.heights = Numbers(json, "heights_mm");
  if (sway.heights.size() < 2 || sway.heights.size() > SwayErrors::kMostHeights) {
    throw BadModel{"'heights_mm' of the sway has " + std::to_string(sway.heights.size()) + " entries"};
  }
  sway.covariance = SymmetricFromJson(json, "covariance", 3 * sway.heights.size());
  return sway;
}

bool Has(const Json& model, const char* key) {
  const auto found = model.find(key);
  return found != model.end() && !found->is_null();
}

}  // namespace

Json CalibrationToJson(const std::optional<SystematicErrors>& errors) {
  if (!errors || !errors->calibration) return nullptr;
  Json json;
  json["directions"] = errors->calibration->offset_covariance.rows();
  json["encoding"] = kEncoding;
  json["offset_covariance_mm2"] = LowerTriangle(errors->calibration->offset_covariance);
  json["height_scale_sigma"] = errors->calibration->height_scale_sigma;
  json["height_offset_sigma_mm"] = errors->calibration->height_offset_sigma;
  return json;
}

Json SwayToJson(const std::optional<SystematicErrors>& errors) {
  if (!errors || !errors->sway) return nullptr;
  Json json{{"sigma_x_mm", errors->sway->sigma_x},
            {"sigma_y_mm", errors->sway->sigma_y},
            {"correlation_length_mm", errors->sway->correlation_length}};
  if (errors->sway->full()) {
    json["heights_mm"] = errors->sway->heights;
    json["encoding"] = kEncoding;
    json["covariance"] = LowerTriangle(errors->sway->covariance);
  }
  return json;
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
