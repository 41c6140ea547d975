#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/scan_plan.h"
#include "acquisition/scan_quality.h"
#include "acquisition/scan_run.h"
#include "acquisition/sealed_file.h"
#include "base/progress.h"
#include "base/result.h"
#include "base/storage.h"
#include "station/config.h"

namespace annulus {

/// What to scan, and where the recording goes.
struct ScanRequest {
  std::string profile;  ///< Built in, or of the configuration.
  std::string out;      ///< Recording to write; replaced if it is there.
  std::string subject_id;
  std::string consent_reference;
  const KeySource* keys = nullptr;  ///< Seals the recording; null: plain. Borrowed.
};

/// How a scan went.
struct ScanOutcome {
  ScanPlan plan;                      ///< What was carried out.
  std::vector<std::string> adjusted;  ///< Why it is not what was asked for; empty if it is.
  ScanSummary summary;
  std::optional<ScanQuality> quality;  ///< What the scan is good for; nothing if nothing was recorded.
  bool recorded = false;  ///< False only if the scan was cancelled before its first level: then there is no file.
};

/// Runs one scan on the booth of `config`, from the reset button to the recording: home → plan (the head's top is
/// searched for unless the profile gives it) → arm → start key → scan. On a simulated booth somebody presses the
/// buttons, and all is in virtual time. A stop request ends it in order; what was taken is kept (summary.cancelled).
/// After a device's error too, and the error then says where it is.
Result<ScanOutcome> RunScanJob(const Config& config, const ScanRequest& request, Storage& storage,
                               const TaskContext& task);

}  // namespace annulus
