#pragma once

#include "acquisition/calibration_file.h"
#include "tests/acquisition/scan_fixture.h"

namespace annulus::test {

/// A calibration file of a ring of two boards of four sensors in which every number has many digits.
inline CalibrationFile MakeCalibrationFile() {
  CalibrationFile file;
  file.calibration = MakeScan(1, 8).header.calibration;
  MakeWhole(file.calibration);
  file.calibration.certificate.clear();
  file.calibration.ring_serial = "ring-01234567";
  file.program_version = "0.1.0";
  file.wall_ns = 1'780'000'000'000'000'001;
  file.valid_until_ns = file.wall_ns + 86'400'000'000'000;
  file.boards = {{1001, 0, 4, 2, "1.2.0"}, {4'294'967'295U, 4, 4, 2, "1.2.0"}};
  CalibrationTarget cylinder;
  cylinder.serial = "C-\u00b5";
  cylinder.certificate_number = "K \"4711\"";
  cylinder.radius_mm = 150.0 + 0.1;
  cylinder.expanded_u_mm = 0.02;
  cylinder.expansion_per_c = 23e-6;
  CalibrationTarget step = cylinder;
  step.kind = CalibrationTarget::Kind::kStep;
  step.step_mm = 10.0;
  step.edges_mm = {100.1, 300.2};
  file.targets = {cylinder, step};
  file.traceable = true;
  file.passed = true;
  file.technician = "T. Ester\nZürich";
  file.ambient_c = 21.3;
  for (int i = 0; i < 8; ++i) {
    Eigen::Matrix<double, 7, 7> root = Eigen::Matrix<double, 7, 7>::Constant(0.01 * (i + 1) / 3.0);
    root.diagonal().setConstant(1.0 / 3.0);
    Eigen::Matrix<double, 7, 7> covariance = root * root.transpose();
    covariance.triangularView<Eigen::StrictlyUpper>() = covariance.transpose().eval();
    file.sensor_covariance.push_back(covariance);
  }
  file.unobservable = {"z scale", "carriage pitch"};
  file.recordings = {"sha256:aa", "sha256:bb"};
  file.history = {{"sha256:cc", 1'770'000'000'000'000'000, -0.1 / 3.0, 0.2 / 3.0, true},
                  {"sha256:dd", 1'775'000'000'000'000'000, 0.0, 1e-300, false}};
  return file;
}

/// Equal to the last bit; versions of boards are not in the file.
inline bool SameFile(const CalibrationFile& a, const CalibrationFile& b) {
  const auto same_board = [](const RecordedBoard& x, const RecordedBoard& y) {
    return x.serial == y.serial && x.first_sensor == y.first_sensor && x.sensor_count == y.sensor_count;
  };
  return SameCalibration(a.calibration, b.calibration) && a.program_version == b.program_version &&
         a.wall_ns == b.wall_ns && a.valid_until_ns == b.valid_until_ns && a.boards.size() == b.boards.size() &&
         std::equal(a.boards.begin(), a.boards.end(), b.boards.begin(), same_board) && a.targets == b.targets &&
         a.traceable == b.traceable && a.passed == b.passed && a.technician == b.technician &&
         a.ambient_c == b.ambient_c && a.sensor_covariance == b.sensor_covariance && a.unobservable == b.unobservable &&
         a.recordings == b.recordings && a.history == b.history;
}

}  // namespace annulus::test
