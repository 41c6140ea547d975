#include "fitting/ring_covariance.h"

#include <algorithm>
#include <cmath>

#include "base/ensure.h"

namespace annulus {
namespace {

using Kind = CalibrationTarget::Kind;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

constexpr double kExact = 1e-9;  // sd of what is held, in its unit

double Precision(double sigma) { return 1.0 / std::max(sigma * sigma, kExact * kExact); }

}  // namespace

PriorSigmas PriorsOf(const RingTolerances& t, const std::vector<CalibrationTarget>& targets,
                     const std::vector<TargetScan>& scans) {
  constexpr double kAnywhere = 500.0;  // mm
  constexpr double kAnyTurn = 10.0;    // rad
  constexpr double kAnySlope = 0.5;
  PriorSigmas priors;
  priors.sensor << t.offset_mm, 100.0 * t.scale, t.position_mm, t.position_mm, t.position_mm,
      kWorkingDistance * t.aim_rad, kWorkingDistance * t.aim_rad;
  priors.ring << t.common_offset_mm, 100.0 * t.common_scale, 1e4 * t.quadratic_per_mm, t.ring_tilt_rad, t.ring_tilt_rad,
      t.height_scale, t.temperature_mm_per_c, t.pitch_rad_per_mm, t.pitch_rad_per_mm;
  priors.path_mm = t.path_mm;
  for (const TargetScan& scan : scans) {
    const bool column = targets[scan.target].kind == Kind::kCylinder || targets[scan.target].kind == Kind::kStep;
    PoseUnknowns pose;
    pose << kAnywhere, kAnywhere, kAnySlope, kAnySlope, column && scan.turn ? t.turn_rad : kAnyTurn, kAnywhere;
    priors.poses.push_back(pose);
  }
  for (const CalibrationTarget& target : targets) {
    FormUnknowns form = FormUnknowns::Constant(t.out_of_round_mm);
    form[0] = target.kind == Kind::kPlane ? kAnywhere : 0.5 * target.expanded_u_mm;
    form[1] = 500.0 * t.taper;
    if (target.kind == Kind::kSphere || target.kind == Kind::kPlane) form.tail(kFormUnknowns - 1).setConstant(kExact);
    priors.forms.push_back(form);
  }
  return priors;
}

RingCovariance::RingCovariance(const CalibrationSetup& setup, const CalibrationState& state, const PriorSigmas& priors,
                               const HeldUnknowns& held)
    : sensor_prior_(priors.sensor), path_prior_mm_(priors.path_mm), held_sensors_(held.sensors) {
  poses_at_ = ring_unknown::kCount + 2 * static_cast<Eigen::Index>(state.ring.path.size());
  forms_at_ = poses_at_ + kPoseUnknowns * static_cast<Eigen::Index>(setup.scans.size());
  shared_ = forms_at_ + kFormUnknowns * static_cast<Eigen::Index>(setup.targets.size());
  SetPriors(setup, priors, held);
  Normal normal = PriorNormal();
  AddBins(setup, state, normal);
  Eliminate(normal, held);
}

void RingCovariance::SetPriors(const CalibrationSetup& setup, const PriorSigmas& priors, const HeldUnknowns& held) {
  shared_prior_ = Eigen::VectorXd::Constant(shared_, priors.path_mm);
  shared_prior_.head<ring_unknown::kCount>() = priors.ring;
  if (held.ring) shared_prior_.head(poses_at_).setConstant(kExact);
  for (std::size_t p = 0; p < setup.scans.size(); ++p) {
    for (int k = 0; k < kPoseUnknowns; ++k) {
      shared_prior_[PoseAt(p) + k] = held.poses[p][static_cast<std::size_t>(k)] ? kExact : priors.poses[p][k];
    }
  }
  for (std::size_t t = 0; t < setup.targets.size(); ++t) {
    shared_prior_.segment<kFormUnknowns>(FormAt(t)) = priors.forms[t];
  }
}

RingCovariance::Normal RingCovariance::PriorNormal() const {
  Normal normal;
  const std::size_t sensors = held_sensors_.size();
  Matrix7 sensor_precision = Matrix7::Zero();
  for (int k = 0; k < 7; ++k) sensor_precision(k, k) = Precision(sensor_prior_[k]);
  normal.own.assign(sensors, sensor_precision);
  for (std::size_t i = 0; i < sensors; ++i) {
    if (held_sensors_[i]) normal.own[i].diagonal().setConstant(Precision(0.0));
  }
  normal.coupling.assign(sensors, Eigen::Matrix<double, 7, Eigen::Dynamic>::Zero(7, shared_));
  normal.common = Eigen::MatrixXd::Zero(shared_, shared_);
  for (Eigen::Index k = 0; k < shared_; ++k) normal.common(k, k) = Precision(shared_prior_[k]);
  return normal;
}

void RingCovariance::AddBins(const CalibrationSetup& setup, const CalibrationState& state, Normal& normal) {
  constexpr int kWidth = ring_unknown::kCount + 4 + kPoseUnknowns + kFormUnknowns;
  Eigen::Matrix<double, 1, kWidth> values;
  std::array<Eigen::Index, kWidth> places{};
  BinRow row;
  for (std::size_t p = 0; p < setup.placements.size(); ++p) {
    for (const TargetBin& bin : setup.placements[p].bins) {
      if (!EvaluateBin(setup, state, p, bin, row)) continue;
      ++bins_;
      const double size = std::abs(row.residual);
      const double weight = size > setup.huber_sds ? setup.huber_sds / size : 1.0;
      chi_square_ += weight * size * size;
      Eigen::Index n = 0;
      const auto put = [&](Eigen::Index at, const auto& block) {
        for (Eigen::Index k = 0; k < block.size(); ++k) {
          places[static_cast<std::size_t>(n)] = at + k;
          values[n++] = block[k];
        }
      };
      put(0, row.by_ring);
      put(PathAt(row.knot), row.by_knot);
      put(PathAt(row.knot + 1), row.by_next_knot);
      put(PoseAt(p), row.by_pose);
      put(FormAt(setup.scans[p].target), row.by_form);
      normal.own[bin.sensor] += weight * row.by_sensor.transpose() * row.by_sensor;
      for (Eigen::Index a = 0; a < n; ++a) {
        if (values[a] == 0.0) continue;
        const Eigen::Index at = places[static_cast<std::size_t>(a)];
        normal.coupling[bin.sensor].col(at) += (weight * values[a]) * row.by_sensor.transpose();
        for (Eigen::Index b = 0; b <= a; ++b) {
          normal.common(at, places[static_cast<std::size_t>(b)]) += weight * values[a] * values[b];
        }
      }
    }
  }
}

void RingCovariance::Eliminate(Normal& normal, const HeldUnknowns& held) {
  const std::size_t sensors = held_sensors_.size();
  own_.reserve(sensors);
  coupling_.reserve(sensors);
  for (std::size_t i = 0; i < sensors; ++i) {
    own_.emplace_back(normal.own[i]);
    coupling_.push_back(own_.back().solve(normal.coupling[i]));
    normal.common.triangularView<Eigen::Lower>() -= normal.coupling[i].transpose() * coupling_.back();
  }
  Eigen::MatrixXd schur = normal.common.selfadjointView<Eigen::Lower>();
  std::vector<Eigen::Index> considered;
  for (int k = 0; k < ring_unknown::kCount; ++k) {
    if (held.considered[static_cast<std::size_t>(k)]) considered.push_back(k);
  }
  Eigen::MatrixXd columns(shared_, static_cast<Eigen::Index>(considered.size()));
  for (std::size_t c = 0; c < considered.size(); ++c) {
    const auto column = static_cast<Eigen::Index>(c);
    columns.col(column) = schur.col(considered[c]);
    for (const Eigen::Index other : considered) columns(other, column) = 0.0;
  }
  for (const Eigen::Index k : considered) {
    schur.row(k).setZero();
    schur.col(k).setZero();
    schur(k, k) = Precision(0.0);
  }
  reduced_.compute(schur);
  ENSURE(reduced_.info() == Eigen::Success, "priors make the calibration's normal matrix definite");
  // What is taken d too small moves all others by -S^-1 · column · d, to fit the readings as well as they can.
  followed_ = -reduced_.solve(columns);
  for (std::size_t c = 0; c < considered.size(); ++c) {
    const auto column = static_cast<Eigen::Index>(c);
    followed_(considered[c], column) = 1.0;
    followed_.col(column) *= shared_prior_[considered[c]];
  }
}

RingFunctional RingCovariance::Zero() const { return {{}, Eigen::VectorXd::Zero(shared_)}; }

Eigen::VectorXd RingCovariance::Reduced(const RingFunctional& f) const {
  Eigen::VectorXd q = f.by_shared;
  for (std::size_t i = 0; i < f.by_sensor.size(); ++i) q -= coupling_[i].transpose() * f.by_sensor[i];
  return q;
}

double RingCovariance::Covariance(const RingFunctional& f, const RingFunctional& g) const {
  const Eigen::VectorXd by_f = Reduced(f);
  const Eigen::VectorXd by_g = Reduced(g);
  double sum = by_f.dot(reduced_.solve(by_g)) + (followed_.transpose() * by_f).dot(followed_.transpose() * by_g);
  for (std::size_t i = 0; i < std::min(f.by_sensor.size(), g.by_sensor.size()); ++i) {
    sum += f.by_sensor[i].dot(own_[i].solve(g.by_sensor[i]));
  }
  return sum;
}

double RingCovariance::ConsideredVariance(const RingFunctional& f) const {
  return (followed_.transpose() * Reduced(f)).squaredNorm();
}

double RingCovariance::PriorVariance(const RingFunctional& f) const {
  double sum = f.by_shared.cwiseProduct(shared_prior_).squaredNorm();
  for (std::size_t i = 0; i < f.by_sensor.size(); ++i) {
    if (!held_sensors_[i]) sum += f.by_sensor[i].cwiseProduct(sensor_prior_).squaredNorm();
  }
  return sum;
}

Matrix7 RingCovariance::OfSensor(std::size_t sensor) const {
  const auto& w = coupling_[sensor];
  const Eigen::MatrixXd following = w * followed_;
  return own_[sensor].solve(Matrix7::Identity()) + w * reduced_.solve(w.transpose()) +
         following * following.transpose();
}

Eigen::MatrixXd RingCovariance::Joint(const std::vector<SensorUnknowns>& by_sensor,
                                      const Eigen::MatrixXd& by_shared) const {
  const auto n = static_cast<Eigen::Index>(by_sensor.size());
  Eigen::MatrixXd q = by_shared.transpose();  // shared x sensors
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    q.col(i) -= coupling_[k].transpose() * by_sensor[k];
  }
  const Eigen::MatrixXd half = reduced_.matrixL().solve(q);
  const Eigen::MatrixXd following = q.transpose() * followed_;
  Eigen::MatrixXd covariance = half.transpose() * half + following * following.transpose();
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    covariance(i, i) += by_sensor[k].dot(own_[k].solve(by_sensor[k]));
  }
  return covariance;
}

}  // namespace annulus
