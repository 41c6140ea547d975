#include "modeling/glasses/glasses_rank.h"

#include <gtest/gtest.h>

#include <set>

#include "sim/random_head.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

class RankOnAHead : public testing::Test {
 protected:
  RankOnAHead()
      : model_(test::HeadSurface(sim::MakeRandomHead(4))),
        measured_(MeasuredSurface::FromModel(model_).value()),
        head_(WearerHead::Look(measured_, {}).value()) {}

  SurfaceModel model_;
  MeasuredSurface measured_;
  WearerHead head_;
};

TEST_F(RankOnAHead, DoesNotDependOnTheNumberOfThreads) {
  std::vector<RankCandidate> candidates = CandidatesOf(BuiltInFrameLibrary());
  candidates.resize(16);
  RankOptions one;
  one.threads = 1;
  RankOptions three;
  three.threads = 3;
  const auto a = RankFrames(head_, candidates, one, {});
  const auto b = RankFrames(head_, candidates, three, {});
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->size(), candidates.size());
  for (std::size_t k = 0; k < a->size(); ++k) {
    EXPECT_EQ((*a)[k].candidate.style, (*b)[k].candidate.style);
    EXPECT_EQ((*a)[k].candidate.size, (*b)[k].candidate.size);
    EXPECT_EQ((*a)[k].score, (*b)[k].score);
  }
}

TEST_F(RankOnAHead, PutsFramesThatCannotBeWornLastAndSaysWhy) {
  const auto ranked = RankFrames(head_, CandidatesOf(BuiltInFrameLibrary()), {}, {});
  ASSERT_TRUE(ranked);
  bool fits = true;
  for (std::size_t k = 0; k < ranked->size(); ++k) {
    const RankedFrame& frame = (*ranked)[k];
    EXPECT_TRUE(fits || !frame.wearable) << k;
    fits = frame.wearable;
    EXPECT_EQ(frame.wearable, frame.advice.empty());
    if (k > 0 && (*ranked)[k - 1].wearable == frame.wearable) {
      EXPECT_GE((*ranked)[k - 1].score, frame.score);
    }
  }
  EXPECT_TRUE(ranked->front().wearable) << "of 90 frames at least one fits an adult";
}

TEST_F(RankOnAHead, TriesEveryStyleInEverySize) {
  std::size_t expected = 0;
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    expected += std::max<std::size_t>(style.sizes.size(), 1);
  }
  std::set<std::pair<std::string, std::string>> names;
  for (const RankCandidate& candidate : CandidatesOf(BuiltInFrameLibrary())) {
    names.emplace(candidate.style, candidate.size);
  }
  EXPECT_EQ(names.size(), expected);
}

TEST_F(RankOnAHead, StopsWhenAsked) {
  std::stop_source stop;
  stop.request_stop();
  TaskContext task;
  task.stop = stop.get_token();
  EXPECT_FALSE(RankFrames(head_, CandidatesOf(BuiltInFrameLibrary()), {}, task));
}

}  // namespace
}  // namespace annulus
