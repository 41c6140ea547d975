#include "fitting/surface_fitter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fitting/fit_segments.h"
#include "tests/fitting/synthetic_scan.h"

namespace annulus {
namespace {

/// A scan's samples by level, in the order of scanning.
std::vector<std::vector<SurfaceSample>> Levels(const std::vector<SurfaceSample>& samples) {
  std::vector<std::vector<SurfaceSample>> levels;
  for (const SurfaceSample& sample : samples) {
    if (sample.level >= levels.size()) levels.resize(sample.level + 1);
    levels[sample.level].push_back(sample);
  }
  return levels;
}

TEST(SurfaceFitter, EndsWithTheSurfaceOfTheBatch) {
  test::ScanShape shape;
  shape.levels = 70;
  const std::vector<SurfaceSample> samples = test::SyntheticScan(test::SmoothTrunk, shape);
  SurfaceFitter fitter{FitOptions{}};
  for (const auto& level : Levels(samples)) fitter.AddLevel(level);
  const auto streamed = fitter.Finish({});
  ASSERT_TRUE(streamed.has_value()) << streamed.error().Text();
  const auto batch = FitBody(samples, {}, {});
  ASSERT_TRUE(batch.has_value());
  const SplineSurface& a = streamed->model.main().surface;
  const SplineSurface& b = batch->model.main().surface;
  ASSERT_EQ(a.coefficients().size(), b.coefficients().size());
  EXPECT_LE((a.coefficients() - b.coefficients()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(SurfaceFitter, ShowsWhatItHasSeenEveryThirtyLevels) {
  test::ScanShape shape;
  shape.levels = 100;
  shape.noise = 0.3;
  SurfaceFitter fitter{FitOptions{}};
  std::vector<std::size_t> shown;
  for (const auto& level : Levels(test::SyntheticScan(test::SmoothTrunk, shape))) {
    fitter.AddLevel(level);
    if (!fitter.preview_due()) continue;
    const auto preview = fitter.Preview();
    ASSERT_TRUE(preview.has_value()) << preview.error().Text();
    shown.push_back(fitter.levels());
    const SplineSurface& surface = preview->main().surface;
    EXPECT_EQ(preview->main().normal_matrix.nonZeros(), 0);
    const auto [low, high] = std::minmax_element(fitter.samples().begin(), fitter.samples().end(),
                                                 [](const auto& x, const auto& y) { return x.z < y.z; });
    EXPECT_DOUBLE_EQ(surface.z_min(), low->z);
    EXPECT_DOUBLE_EQ(surface.z_max(), high->z);
    // Smooth within 2 mm of the truth all over: it is there to be looked at.
    for (double theta = 0.0; theta < kTwoPi; theta += 0.1) {
      const double z = 0.5 * (low->z + high->z);
      EXPECT_NEAR(surface.Radius(theta, z), test::SmoothTrunk(theta, z), 2.0);
    }
  }
  EXPECT_EQ(shown, (std::vector<std::size_t>{30, 60, 90}));
}

TEST(SurfaceFitter, SaysWhenThereIsTooLittleYet) {
  SurfaceFitter fitter{FitOptions{}};
  EXPECT_FALSE(fitter.preview_due());
  EXPECT_FALSE(fitter.Preview().has_value());
  fitter.AddLevel({});
  EXPECT_FALSE(fitter.Finish({}).has_value());
}

}  // namespace
}  // namespace annulus
