#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "station/console/console_context.h"

namespace annulus {

struct OpenModel;

/// How a scan is to be fitted.
struct FitJobOptions {
  std::string method = "adaptive";  ///< As `annulus fit --method`.
  bool covariance = true;
};

/// Starts the job that makes a scan's model (in a process of its own), its landmarks and its measurements, and puts
/// them into the store as artefacts; earlier landmarks by hand are kept. Its result: {scan_id, model}. Returns the
/// job's id. Fails if the recording cannot be read or there is no room for it.
Result<std::string> StartFitJob(ConsoleContext& context, const std::string& scan_id, const std::string& owner,
                                const FitJobOptions& options = {});

/// Landmarks and measurements of a model, as they are now, into the store.
Status KeepMeasurements(ConsoleContext& context, const OpenModel& model);
/// The same of a scan's model, which is opened.
Status KeepMeasurements(ConsoleContext& context, const std::string& scan_id);

}  // namespace annulus
