#pragma once

#include <string>
#include <vector>

#include "base/progress.h"
#include "base/result.h"
#include "modeling/glasses/frame_library.h"
#include "modeling/glasses/glasses_fit.h"

namespace annulus {

/// One frame of a library in one size.
struct RankCandidate {
  std::string style;
  std::string size;       ///< "medium"; "" for a style without sizes, which is made to measure.
  std::string size_text;  ///< "52□18-140", as frames are marked.
  FrameDesign design;
  std::optional<double> temple_length;  ///< Overall, mm.
};

/// Every style of the library in each of its sizes, in the library's order. Sizes that cannot be built are left out.
[[nodiscard]] std::vector<RankCandidate> CandidatesOf(const FrameLibrary& library);

/// How a frame did.
struct RankedFrame {
  RankCandidate candidate;
  double score = 0.0;               ///< 0 … 100, GlassesFit::score.
  bool wearable = false;            ///< Contacts hold, nothing enters, every goal is met.
  std::vector<std::string> advice;  ///< What is wrong, most important first; empty if wearable.
  std::vector<FitGoal> goals;       ///< Without sigmas; empty if the frame could not be put on.
};

struct RankOptions {
  GlassesFitOptions fit;  ///< `detail` and `size` are not looked at: sizes are kept.
  int threads = 2;        ///< >= 1. The result does not depend on it.
};

/// Puts every candidate on the head and sorts: wearable ones first, then by score, then by style and size. Reports
/// progress and stops early with an error if asked to.
[[nodiscard]] Result<std::vector<RankedFrame>> RankFrames(const WearerHead& head,
                                                          const std::vector<RankCandidate>& candidates,
                                                          const RankOptions& options, const TaskContext& task);

}  // namespace annulus
