// Many operations in a row, of every kind that keeps the volume.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>

#include "modeling/clay/clay_joins.h"
#include "modeling/clay/clay_operation.h"
#include "tests/modeling_clay/clay_check.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

class RandomActs {
 public:
  /// An act on the block's inner top patches, away from the sharp edges that a tool folds, or on the whole body; tools
  /// of 0.7 to 1.2 mm, patches of 1 mm. Half of them push or pull, a quarter smooths what the others roughen.
  ClayAct Next() {
    ToolHold hold;
    hold.at = Place();
    hold.radius_mm = In(0.7, 1.2);
    const double depth = In(-0.05, 0.05);
    ToolHold hand = hold;
    hand.tool = ClayTool::kHand;
    const std::size_t kind = engine_() % 40;
    if (kind < 12) return PushAct{hold, depth, 1, In(1.5, 2.5)};
    if (kind < 16) return PushAct{hold, depth, 2, 2.0};
    if (kind < 18) return PushAct{hand, depth, 1, In(1.5, 2.0)};
    if (kind < 20) return PushAct{Spatula(hold), depth, 2, 2.0};
    if (kind < 29) return SmoothAct{hand, In(0.3, 0.7), 3};
    if (kind < 34) return Line(hold, kind < 32 ? LineAct::How::kDraw : LineAct::How::kErase);
    if (kind < 36) return Hole(hold, kind == 34);
    if (kind == 36) return SpreadAct{hand, In(0.0, 0.05)};
    return OfTheWholeBody(kind);
  }

 private:
  double In(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11U) * 0x1.0p-53; }
  ClayAddress Place() {
    const std::size_t column = 1 + engine_() % 4;
    const std::size_t row = 1 + engine_() % 4;
    return {static_cast<std::uint32_t>(6 * row + column), In(0.0, 1.0), In(0.0, 1.0)};
  }
  ToolHold Spatula(ToolHold hold) {
    hold.tool = ClayTool::kSpatula;
    hold.length_mm = 2.5 * hold.radius_mm;
    hold.angle_rad = In(0.0, 2.0 * std::numbers::pi);
    return hold;
  }
  ClayAct Line(const ToolHold& hold, LineAct::How how) {
    LineAct act;
    act.how = how;
    act.path = {hold.at, {hold.at.patch, In(0.0, 1.0), In(0.0, 1.0)}};
    act.radius_mm = 0.7;
    act.depth_mm = 0.03;
    return act;
  }
  ClayAct Hole(const ToolHold& hold, bool made) {
    HoleAct act;
    act.hold = hold;
    act.how = made ? HoleAct::How::kMake : (engine_() % 2 == 0 ? HoleAct::How::kWiden : HoleAct::How::kClose);
    act.depth_mm = In(0.05, 0.1);
    act.factor = In(1.02, 1.1);
    return act;
  }
  ClayAct OfTheWholeBody(std::size_t kind) {
    const ClayAxis axis{Vector3d(In(-1.8, -1.2), 0.0, -1.5), Vector3d(In(1.2, 1.8), 0.0, -1.5)};
    const double factor = In(0.95, 1.0);
    if (kind == 37) return TwistAct{axis, In(-0.1, 0.1)};
    if (kind == 38) return StretchAct{axis, engine_() % 2 == 0 ? factor : 1.0 / factor};
    if (engine_() % 2 == 0) return BallAct{In(0.0, 0.02)};
    return KneadAct{0.01, In(3.0, 6.0), engine_() % 1000};
  }

  std::mt19937_64 engine_{1};
};

/// ANNULUS_LONG=1: ten thousand that are carried out, else a twentieth of them.
TEST(ClayEndurance, TenThousandOfAllKindsKeepTheVolumeAndTheSkin) {
  auto body = ClayBody::Make(test::RoundBlock());
  ASSERT_TRUE(body);
  const double start = body->volume();
  const char* length = std::getenv("ANNULUS_LONG");
  const int wanted = length != nullptr && *length == '1' ? 10'000 : 500;
  RandomActs acts;
  int done = 0;
  int refused = 0;
  double worst = 0.0;
  std::size_t most_leaves = 0;
  while (done < wanted) {
    const ClayAct act = acts.Next();
    const auto report = Perform(*body, act);
    if (!report) {
      ASSERT_LT(++refused, wanted / 10) << report.error().Text();
      continue;
    }
    ++done;
    ASSERT_LE(std::abs(report->volume_after_mm3 / start - 1.0), 1e-12) << NameOf(act) << ", number " << done;
    worst = std::max(worst, std::abs(report->volume_after_mm3 / start - 1.0));
    most_leaves = std::max(most_leaves, report->patches);
    if (done % 250 != 0) continue;
    const test::JoinErrors errors = test::MeasureLeafJoins(body->mesh());
    ASSERT_LE(errors.gap, 1e-9) << done;
    ASSERT_LE(errors.kink, 1e-6) << done;
  }
  RecordProperty("refused", refused);
  RecordProperty("most_leaves", static_cast<int>(most_leaves));
  RecordProperty("worst_volume_error_e18", static_cast<int>(worst * 1e18));
  // What is kept is kept by the cones of today, too, not only by the sum that was carried along.
  EXPECT_NEAR(std::move(*ClayBody::Make(body->mesh())).volume(), start, 1e-12 * start);
}

}  // namespace
}  // namespace annulus
