#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "base/storage.h"
#include "fitting/fit_surface.h"
#include "modeling/glasses/glasses_fit.h"
#include "modeling/table/table.h"
#include "station/scan_job.h"
#include "station/truth_table.h"

namespace annulus {

/// What the demo shows.
struct DemoOptions {
  std::string folder;                 ///< Made if it is not there; what an earlier demo left there is replaced.
  std::vector<std::string> subjects;  ///< "body", "head", in this order.
  std::uint64_t seed = 1;             ///< Of all randomness.
};

struct DemoPicture {
  std::string file;  ///< Name in the folder.
  std::string caption;
  std::vector<std::byte> png;
};

struct DemoFile {
  std::string name;
  std::string purpose;
};

/// How much of a surface was seen, 0 … 1; the three add up to 1.
struct KnowledgeShares {
  double measured = 0.0;
  double inferred = 0.0;
  double unknown = 0.0;
};

/// Glasses that were put on the subject.
struct DemoGlasses {
  std::string style;
  GlassesFit fit;
};

/// The chain on one subject.
struct DemoSubject {
  std::string name;   ///< "body"
  std::string title;  ///< "Standing person"
  ScanOutcome scan;
  FitSummary fit;
  KnowledgeShares shares;
  MeasurementTable table;
  std::vector<TruthComparison> comparisons;
  std::optional<DemoGlasses> glasses;
  std::vector<DemoPicture> pictures;
  std::vector<DemoFile> files;
};

struct DemoResult {
  std::uint64_t seed = 0;
  std::vector<DemoSubject> subjects;
};

/// The whole chain on the simulated booth: scan → recording → surface → measurements → glasses → pictures →
/// report.html. Every file appears complete or not at all. Fails as its steps do; a stop request leaves the files of
/// finished steps and the recording.
Result<DemoResult> RunDemo(const DemoOptions& options, Storage& storage, const TaskContext& task);

}  // namespace annulus
