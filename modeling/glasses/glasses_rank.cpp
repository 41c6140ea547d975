#include "modeling/glasses/glasses_rank.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <tuple>
#include <utility>

#include "modeling/glasses/boxing.h"
#include "modeling/glasses/design_request.h"

namespace annulus {
namespace {

RankedFrame TryOn(const WearerHead& head, const RankCandidate& candidate, const GlassesFitOptions& options) {
  RankedFrame ranked;
  ranked.candidate = candidate;
  GlassesFitOptions fit_options = options;
  fit_options.detail = FitDetail::kRanking;
  fit_options.size = FitSize::kKept;
  fit_options.temple_length = candidate.temple_length;
  // A style without sizes is the paper's: scaled to the pupillary distance (step 1 of paper 000, §5).
  const double spacing = (head.eye(Eye::kRight) - head.eye(Eye::kLeft)).norm();
  const FrameDesign design = candidate.size.empty() && spacing > candidate.design.details.bridge_gap.value_or(0.0)
                                 ? ScaledToSpacing(candidate.design, spacing)
                                 : candidate.design;
  auto fit = FitGlasses(head, design, fit_options);
  if (!fit) {
    ranked.advice = {fit.error().seen};
    return ranked;
  }
  ranked.score = fit->score;
  ranked.wearable = fit->wearable;
  ranked.advice = std::move(fit->advice);
  ranked.goals = std::move(fit->goals);
  return ranked;
}

}  // namespace

std::vector<RankCandidate> CandidatesOf(const FrameLibrary& library) {
  std::vector<RankCandidate> candidates;
  for (const LibraryStyle& style : library.styles) {
    if (style.sizes.empty()) candidates.push_back({style.name, "", "", style.design, std::nullopt});
    for (const SoldSize& size : style.sizes) {
      const auto composed = ComposeDesign(library, {style.name, size.name, {}});
      if (!composed) continue;
      FrameBoxing boxing;
      boxing.a = size.a;
      boxing.dbl = size.dbl;
      candidates.push_back({style.name, size.name, SizeText(boxing, size.temple), composed->file.design, size.temple});
    }
  }
  return candidates;
}

Result<std::vector<RankedFrame>> RankFrames(const WearerHead& head, const std::vector<RankCandidate>& candidates,
                                            const RankOptions& options, const TaskContext& task) {
  std::vector<RankedFrame> ranked(candidates.size());
  std::atomic<std::size_t> next = 0;
  const auto work = [&](bool reports) {
    for (std::size_t k = next++; k < candidates.size(); k = next++) {
      if (task.stop.stop_requested()) return;
      ranked[k] = TryOn(head, candidates[k], options.fit);
      if (reports) task.Report("trying frames on", static_cast<double>(k), static_cast<double>(candidates.size()));
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int k = 1; k < options.threads; ++k) helpers.emplace_back([&work] { work(false); });
    work(true);
  }
  if (task.stop.stop_requested()) {
    return Fail("rank the frames", "it was asked to stop", "run it again");
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const RankedFrame& a, const RankedFrame& b) {
    // The better one first: wearable before not, higher score before lower, then by name.
    return std::make_tuple(!a.wearable, -a.score, a.candidate.style, a.candidate.size_text) <
           std::make_tuple(!b.wearable, -b.score, b.candidate.style, b.candidate.size_text);
  });
  return ranked;
}

}  // namespace annulus
