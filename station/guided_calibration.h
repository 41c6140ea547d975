#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "acquisition/scan.h"
#include "acquisition/sealed_file.h"
#include "base/progress.h"
#include "base/result.h"
#include "base/storage.h"
#include "station/calibration_guide.h"
#include "station/calibration_plan.h"
#include "station/config.h"

namespace annulus {

/// A placement that was scanned.
struct TakenPlacement {
  Scan scan;
  double seconds = 0.0;  ///< That it took, with the move of the target.
};

/// Who scans a placement once the target stands there.
class PlacementTaker {
 public:
  virtual ~PlacementTaker() = default;
  /// Scans placement `step` of the plan into `file`, which is replaced if it is there.
  virtual Result<TakenPlacement> Take(const CalibrationPlan& plan, std::size_t step, const std::string& file,
                                      const TaskContext& task) = 0;
};

/// Scans on the booth of a configuration, real or simulated; the start key says that the target stands. In a simulated
/// booth the target is set up as asked for, about as well as people do that, and the times are the booth's own; if the
/// configuration's [sim.target] is of its kind and radius, it has that one's shape, and what happens to it. Storage and
/// keys are borrowed.
class BoothPlacements final : public PlacementTaker {
 public:
  BoothPlacements(Config config, Storage& storage, const KeySource* keys);

  Result<TakenPlacement> Take(const CalibrationPlan& plan, std::size_t step, const std::string& file,
                              const TaskContext& task) override;

 private:
  [[nodiscard]] SimTarget SimulatedTarget(const CalibrationTarget& target, const PlannedPlacement& placement,
                                          std::size_t step) const;

  Config config_;
  Storage& storage_;
  const KeySource* keys_;
  bool simulated_;
};

/// What a guided run leaves behind: one scan and its file per placement.
struct GuidedScans {
  std::vector<Scan> scans;
  std::vector<std::string> files;
  double seconds = 0.0;  ///< Of all placements, failed tries included.
};

/// Leads through the guide's plan: says what to do, has each placement scanned into `folder`, says how it went, has one
/// that is not good scanned again, and says how well the ring is known by now. Fails if a placement does not succeed in
/// three tries.
Result<GuidedScans> RunGuidedCalibration(const CalibrationGuide& guide, const std::string& folder,
                                         PlacementTaker& taker, const std::function<Status(const std::string&)>& say,
                                         const TaskContext& task);

}  // namespace annulus
