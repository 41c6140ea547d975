#pragma once

#include <optional>
#include <string>

#include "acquisition/scan.h"
#include "acquisition/scan_plan.h"
#include "base/result.h"

namespace annulus {

/// What is to be armed.
struct ArmRequest {
  ScanPlan plan;        ///< As asked for; it is held against the machine, and adjusted if it can be.
  bool search = false;  ///< Finds the subject's top instead (a coarse sweep without a recording); `plan` is ignored.
  std::string out;      ///< Where the recording goes. Empty only for a search.
  /// Station, subject, consent, calibration and so on; the scanner fills in plan, boards and wall clock.
  ScanHeader header;
};

/// What others say before a scan may be armed: each a success, or what is missing and what to do.
struct GateAnswer {
  Status customer;     ///< A customer is bound to this scan.
  Status consent;      ///< And has consented to it.
  Status store;        ///< The store takes the scan's record.
  Status reference;    ///< The ring's reference check is not too old and was good.
  Status calibration;  ///< The ring's calibration is there, whole, of these boards and not expired, or not needed.
};

/// The scanner's view of customers, store and reference check. Called from the worker thread; may take a second.
class ScanGate {
 public:
  virtual ~ScanGate() = default;
  /// `machine`: what is connected now.
  virtual GateAnswer Ask(const ArmRequest& request, const RecordedMachine& machine) = 0;
};

/// Lets everything pass: for simulated booths, and until store and reference check exist.
class PermissiveGate final : public ScanGate {
 public:
  GateAnswer Ask(const ArmRequest&, const RecordedMachine&) override { return {}; }
};

}  // namespace annulus
