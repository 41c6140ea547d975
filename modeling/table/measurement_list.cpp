#include "modeling/table/measurement_list.h"

#include <cmath>
#include <utility>

#include "modeling/measure/systematic.h"

namespace annulus {

void Follow(RawMeasurement& raw, const Estimate& coordinate, double derivative, double placing) {
  const double value = raw.estimate.value;
  raw.estimate = Combine(1.0, raw.estimate, derivative, coordinate);
  raw.estimate.value = value;  // it was taken where the coordinate is
  raw.placing_variance += derivative * derivative * placing * placing;
}

double HeightShare(const std::vector<Eigen::Vector3d>& line) {
  double share = 0.0;
  for (std::size_t k = 0; k + 1 < line.size(); ++k) {
    const Eigen::Vector3d edge = line[k + 1] - line[k];
    if (edge.norm() > 0.0) share += edge.z() * edge.z() / edge.norm();
  }
  return share;
}

MeasurementList::MeasurementList(const MeasuredSurface& body, Landmarks landmarks)
    : body_(&body), landmarks_(std::move(landmarks)) {}

void MeasurementList::Add(MeasurementSpec spec, Result<RawMeasurement> raw) {
  if (raw) {
    raw->spec = std::move(spec);
    raw_.push_back(std::move(*raw));
  } else {
    Omit(spec.term, raw.error().seen);
  }
}

void MeasurementList::Omit(const std::string& term, const std::string& why) {
  omitted_.push_back(term + ": " + why + ".");
}

MeasurementTable MeasurementList::Finish() {
  // Wrong heights move a whole scan, the landmarks with it, found or given: what becomes of a number is known exactly
  // by its height_share and height_offset, and need not be linearised by the gradient, which would count it twice.
  SystematicErrors at_right_heights;
  if (body_->systematic() != nullptr) at_right_heights = *body_->systematic();
  if (at_right_heights.calibration) {
    at_right_heights.calibration->height_scale_sigma = 0.0;
    at_right_heights.calibration->height_offset_sigma = 0.0;
  }
  std::vector<Estimate> estimates;
  for (const RawMeasurement& raw : raw_) estimates.push_back(raw.estimate);
  const std::vector<Uncertain> numbers = body_->WithSigmas(estimates);
  MeasurementTable table;
  table.omitted = landmarks_.omitted;
  table.omitted.insert(table.omitted.end(), omitted_.begin(), omitted_.end());
  table.landmarks = std::move(landmarks_);
  for (std::size_t k = 0; k < raw_.size(); ++k) {
    RawMeasurement& raw = raw_[k];
    UncertaintyBudget budget;
    budget.detail = raw.estimate.unresolved;
    budget.fit = std::sqrt(std::max(0.0, numbers[k].sigma * numbers[k].sigma - budget.detail * budget.detail));
    if (std::isnan(numbers[k].sigma)) budget.fit = numbers[k].sigma;
    budget.landmarks = std::sqrt(raw.placing_variance);
    if (const SystematicErrors* errors = body_->systematic()) {
      const SystematicSigmas sigmas = SigmasOfInvariant(at_right_heights, *body_, raw.estimate);
      const double scale = errors->calibration ? errors->calibration->height_scale_sigma * raw.height_share : 0.0;
      const double offset = errors->calibration ? errors->calibration->height_offset_sigma * raw.height_offset : 0.0;
      budget.calibration = std::hypot(sigmas.calibration, scale, offset);
      budget.sway = sigmas.sway;
    }
    const double sigma = std::hypot(std::hypot(budget.fit, budget.landmarks, budget.detail),
                                    std::hypot(budget.calibration, budget.sway));
    table.measurements.push_back({raw.spec.id,
                                  raw.spec.term,
                                  raw.spec.definition,
                                  raw.spec.unit,
                                  {raw.estimate.value, sigma},
                                  raw.measured_share,
                                  raw.spec.iso20685_limit_mm,
                                  raw.landmarks,
                                  raw.spec.method,
                                  budget,
                                  std::move(raw.paths)});
  }
  raw_.clear();
  omitted_.clear();
  return table;
}

}  // namespace annulus
