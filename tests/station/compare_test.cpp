#include "station/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace annulus {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Measurement Of(const std::string& id, double value, double sigma) {
  Measurement m;
  m.id = id;
  m.term = id;
  m.definition = "Definition of " + id + ".";
  m.method = "tape";
  m.unit = "mm";
  m.value = {value, sigma};
  m.budget.fit = sigma;
  return m;
}

MeasurementTable TableOf(std::vector<Measurement> measurements) {
  MeasurementTable table;
  table.measurements = std::move(measurements);
  return table;
}

SurfaceModel CalibratedBy(const std::string& hash) {
  SurfaceModel model;
  model.provenance.calibration_hash = hash;
  return model;
}

TEST(Compare, AddsTheVariancesOfIndependentScans) {
  const SurfaceModel model = CalibratedBy("");
  const Comparison c = Compare({model, TableOf({Of("waist", 700, 3)})}, {model, TableOf({Of("waist", 710, 4)})});
  ASSERT_EQ(c.differences.size(), 1U);
  EXPECT_DOUBLE_EQ(c.differences[0].difference, 10.0);
  EXPECT_DOUBLE_EQ(c.differences[0].sigma, 5.0);
  EXPECT_DOUBLE_EQ(c.differences[0].z, 2.0);
  EXPECT_NEAR(c.differences[0].p, 0.04550026389635842, 1e-12);  // 2 * scipy.stats.norm.sf(2)
  EXPECT_TRUE(c.differences[0].significant);
  EXPECT_EQ(c.ring, RingErrors::kIndependent);
}

TEST(Compare, LetsTheErrorsOfACommonRingCancel) {
  Measurement a = Of("waist", 700, 5);
  a.budget.calibration = 4;  // of 5: 3 are its own
  Measurement b = Of("waist", 703, std::sqrt(32.0));
  b.budget.calibration = 4;  // 4 are its own
  const SurfaceModel same = CalibratedBy("sha256:1");
  const SurfaceModel other = CalibratedBy("sha256:2");
  const Comparison common = Compare({same, TableOf({a})}, {same, TableOf({b})});
  EXPECT_EQ(common.ring, RingErrors::kCommon);
  EXPECT_NEAR(common.differences[0].sigma, 5.0, 1e-12);
  const Comparison apart = Compare({same, TableOf({a})}, {other, TableOf({b})});
  EXPECT_EQ(apart.ring, RingErrors::kIndependent);
  EXPECT_NEAR(apart.differences[0].sigma, std::sqrt(25.0 + 32.0), 1e-12);
}

TEST(Compare, CorrectsForTheNumberOfTests) {
  // One difference of two sd among five is no finding; the same alone would be.
  std::vector<Measurement> a;
  std::vector<Measurement> b;
  for (const char* id : {"v", "w", "x", "y", "z"}) {
    a.push_back(Of(id, 100, 3));
    b.push_back(Of(id, id[0] == 'v' ? 110 : 101, 4));
  }
  const SurfaceModel model = CalibratedBy("");
  const Comparison c = Compare({model, TableOf(a)}, {model, TableOf(b)});
  EXPECT_NEAR(c.differences[0].p_holm, 5 * 0.04550026389635842, 1e-12);
  for (const Difference& d : c.differences) EXPECT_FALSE(d.significant);
}

TEST(Compare, FollowsHolmsStepsInTheOrderGiven) {
  // statsmodels.stats.multitest.multipletests([0.01, 0.04, 0.03, 0.005], method='holm')[1]
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> corrected = HolmCorrected({0.01, 0.04, nan, 0.03, 0.005});
  EXPECT_NEAR(corrected[0], 0.03, 1e-15);
  EXPECT_NEAR(corrected[1], 0.06, 1e-15);
  EXPECT_TRUE(std::isnan(corrected[2]));
  EXPECT_NEAR(corrected[3], 0.06, 1e-15);
  EXPECT_NEAR(corrected[4], 0.02, 1e-15);
  EXPECT_THAT(HolmCorrected({0.9, 0.8}), ElementsAre(1.0, 1.0));
  EXPECT_TRUE(HolmCorrected({}).empty());
}

TEST(Compare, RefusesToCompareWhatIsDefinedDifferently) {
  Measurement unit = Of("a", 1, 1);
  unit.unit = "deg";
  Measurement method = Of("b", 1, 1);
  method.method = "straight line";
  Measurement definition = Of("c", 1, 1);
  definition.definition = "Another one.";
  const SurfaceModel model = CalibratedBy("");
  const Comparison c = Compare({model, TableOf({Of("a", 1, 1), Of("b", 1, 1), Of("c", 1, 1), Of("d", 1, 1)})},
                               {model, TableOf({unit, method, definition, Of("e", 1, 1)})});
  EXPECT_TRUE(c.differences.empty());
  EXPECT_THAT(c.not_comparable,
              ElementsAre("a: in mm and in deg.", HasSubstr("straight line"), HasSubstr("Another one."),
                          "d: measured in A only.", "e: measured in B only."));
}

TEST(Compare, TestsNothingWithoutASigma) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SurfaceModel model = CalibratedBy("");
  const Comparison c =
      Compare({model, TableOf({Of("a", 1, nan), Of("b", 1, 1)})}, {model, TableOf({Of("a", 99, 1), Of("b", 5, 1)})});
  EXPECT_TRUE(std::isnan(c.differences[0].p_holm));
  EXPECT_FALSE(c.differences[0].significant);
  EXPECT_EQ(c.differences[1].p_holm, c.differences[1].p);  // the only test
  const auto json = ComparisonToJson(c);
  EXPECT_EQ(json.at("tested"), 1);
  EXPECT_TRUE(json.at("differences")[0].at("significant").is_null());
  EXPECT_EQ(json.at("differences")[0].at("difference_mm"), 98.0);
  EXPECT_THAT(ComparisonToText(c), HasSubstr("not known"));
}

TEST(Compare, KnowsNoSignificanceWithoutASigmaWhateverTheRing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SurfaceModel model = CalibratedBy("sha256:1");  // common: the calibration's part is taken off
  const Comparison c = Compare({model, TableOf({Of("a", 1, nan)})}, {model, TableOf({Of("a", 99, nan)})});
  EXPECT_TRUE(std::isnan(c.differences[0].sigma));
  EXPECT_FALSE(c.differences[0].significant);
  EXPECT_THAT(ComparisonToText(c), HasSubstr("not known"));
}

TEST(Compare, OfAScanWithItselfFindsNothing) {
  const SurfaceModel model = CalibratedBy("sha256:1");
  const MeasurementTable table = TableOf({Of("a", 1, 0), Of("b", 1, 1)});
  const Comparison c = Compare({model, table}, {model, table});
  for (const Difference& d : c.differences) {
    EXPECT_EQ(d.difference, 0.0);
    EXPECT_EQ(d.z, 0.0);
    EXPECT_FALSE(d.significant);
  }
}

}  // namespace
}  // namespace annulus
