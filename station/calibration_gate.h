#pragma once

#include <optional>
#include <string>

#include "acquisition/calibration_file.h"
#include "acquisition/scan_gate.h"
#include "base/clock.h"
#include "base/result.h"
#include "base/ring_calibration.h"
#include "base/storage.h"
#include "station/config.h"

namespace annulus {

/// True for profiles that a calibration is made with: "target" and names that begin so. They need no calibration, and
/// carry none. The profile "check" scans a target too, but with the calibration in force, which it is to check.
[[nodiscard]] bool IsTargetProfile(const std::string& profile);

/// What a scan with this profile takes with it into its recording: the calibration in force, or an ideal ring if there
/// is none or a target is scanned. Fails if the file that the configuration names is missing, or the one in force is
/// damaged or of another number of sensors.
[[nodiscard]] Result<RingCalibration> CalibrationInForce(const Config& config, const std::string& profile,
                                                         Storage& storage);

/// Says no to a scan whose ring is not calibrated, as the configuration wants it: reads the calibration file again at
/// every order to arm, and holds it against what the request carries, the boards that are connected, and the date; asks
/// for a fresh and good reference check if the configuration names its file. Customers, consent and store are for
/// others to ask about. Storage and clock are borrowed.
class CalibrationGate final : public ScanGate {
 public:
  CalibrationGate(const Config& config, Storage& storage) : config_(config), storage_(storage) {}

  GateAnswer Ask(const ArmRequest& request, const RecordedMachine& machine) override;

  /// What the time is for validity; the booth's own clock. Nothing: the system's.
  void UseClock(Clock& clock) { clock_ = &clock; }

 private:
  [[nodiscard]] Status AskCalibration(const ArmRequest& request, const RecordedMachine& machine) const;
  [[nodiscard]] Status AskReference(const ArmRequest& request) const;
  [[nodiscard]] std::int64_t WallNow() const;

  Config config_;
  Storage& storage_;
  Clock* clock_ = nullptr;
};

}  // namespace annulus
