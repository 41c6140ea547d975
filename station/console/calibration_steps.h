#pragma once

#include <memory>
#include <string>

#include "acquisition/sealed_file.h"
#include "base/clock.h"
#include "base/storage.h"
#include "station/config.h"
#include "station/console/booth_link.h"
#include "station/guided_calibration.h"

namespace annulus {

/// Scans placements on the booth that boothd runs: home, arm with the target's profile, start once the start key at
/// the booth has been pressed, wait for the result. What boothd recorded stays where it is; a copy of the scan goes to
/// the file that is asked for. Booth, storage, clock and keys are borrowed.
class LinkPlacements final : public PlacementTaker {
 public:
  /// `keys`: of recordings that boothd seals; null: it does not.
  LinkPlacements(BoothLink& booth, Storage& storage, const Clock& clock, const KeySource* keys)
      : booth_(booth), storage_(storage), clock_(clock), keys_(keys) {}

  Result<TakenPlacement> Take(const CalibrationPlan& plan, std::size_t step, const std::string& file,
                              const TaskContext& task) override;

 private:
  BoothLink& booth_;
  Storage& storage_;
  const Clock& clock_;
  const KeySource* keys_;
};

/// Who takes placements for a configuration: a simulated booth of its own, in which targets stand as they are asked
/// for and scans have today's date, where no device is real; else the booth that boothd runs (docs/decisions/0034).
[[nodiscard]] std::unique_ptr<PlacementTaker> PlacementTakerFor(const Config& config, BoothLink& booth,
                                                                Storage& storage, const Clock& clock,
                                                                const KeySource* keys);

/// The plan as a file for `annulus calibrate` (docs/formats.md, "Calibration plan"). `targets`: as ParseTarget took
/// them, one per target of the plan.
[[nodiscard]] std::string CalibrationPlanToml(const CalibrationPlan& plan, const std::vector<std::string>& targets);

}  // namespace annulus
