#include <gtest/gtest.h>

#include <limits>

#include "base/ensure.h"
#include "base/units.h"
#include "fitting/surface_model.h"

namespace annulus {
namespace {

/// 8 columns of 45 degrees and 4 rows of 10 mm from z = 100; cell (c, r) is measured where c == column and r == row.
KnowledgeMap OnlyCell(std::size_t column, std::size_t row) {
  KnowledgeMap map(8, 4, 100.0, 140.0);
  map.SetCell(column, row, Knowledge::kMeasured);
  return map;
}

TEST(KnowledgeMap, IsUnknownUntilTold) {
  const KnowledgeMap map(8, 4, 100.0, 140.0);
  EXPECT_EQ(map.At(1.0, 120.0), Knowledge::kUnknown);
  EXPECT_EQ(KnowledgeMap().At(1.0, 120.0), Knowledge::kUnknown);
}

TEST(KnowledgeMap, CentresColumnZeroOnThetaZero) {
  const KnowledgeMap map = OnlyCell(0, 1);
  const double half = RadiansFromDegrees(22.5);
  for (const double theta : {0.0, half - 1e-9, -half + 1e-9, kTwoPi, kTwoPi - half + 1e-9, -1e-18, 4.0 * kTwoPi}) {
    EXPECT_EQ(map.At(theta, 115.0), Knowledge::kMeasured) << theta;
  }
  for (const double theta : {half + 1e-9, -half - 1e-9, 3.0}) {
    EXPECT_EQ(map.At(theta, 115.0), Knowledge::kUnknown) << theta;
  }
}

TEST(KnowledgeMap, RowsBeginAtZMinAndTheLastOneIncludesZMax) {
  const double theta = RadiansFromDegrees(90.0);  // column 2
  EXPECT_EQ(OnlyCell(2, 0).At(theta, 100.0), Knowledge::kMeasured);
  EXPECT_EQ(OnlyCell(2, 0).At(theta, 109.999), Knowledge::kMeasured);
  EXPECT_EQ(OnlyCell(2, 0).At(theta, 110.001), Knowledge::kUnknown);
  EXPECT_EQ(OnlyCell(2, 3).At(theta, 140.0), Knowledge::kMeasured);
}

TEST(KnowledgeMap, KnowsNothingBeyondItsHeights) {
  KnowledgeMap map(1, 1, 0.0, 1.0);
  map.SetCell(0, 0, Knowledge::kInferred);
  EXPECT_EQ(map.At(2.0, 0.5), Knowledge::kInferred);
  EXPECT_EQ(map.At(2.0, -1e-9), Knowledge::kUnknown);
  EXPECT_EQ(map.At(2.0, 1.0 + 1e-9), Knowledge::kUnknown);
  EXPECT_EQ(map.At(2.0, std::numeric_limits<double>::quiet_NaN()), Knowledge::kUnknown);
}

TEST(KnowledgeMap, NeedsCells) {
  EXPECT_THROW(KnowledgeMap(0, 1, 0.0, 1.0), LogicError);
  EXPECT_THROW(KnowledgeMap(1, 0, 0.0, 1.0), LogicError);
  EXPECT_THROW(KnowledgeMap(1, 1, 1.0, 1.0), LogicError);
}

}  // namespace
}  // namespace annulus
