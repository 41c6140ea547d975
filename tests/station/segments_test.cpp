// Limbs on bodies that the fitter's own tests may not know: the simulated person, and the shared scans.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "acquisition/csv_scan.h"
#include "base/storage.h"
#include "fitting/fit_segments.h"
#include "fitting/segment_axis.h"
#include "sim/person.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

/// What an ideal ring of 180 sensors sees of a subject, level by level.
std::vector<SurfaceSample> Scan(const sim::Subject& subject, double pitch) {
  constexpr double kRingRadius = 1000.0;
  std::vector<SurfaceSample> samples;
  std::uint32_t level = 0;
  for (double z = subject.bottom_mm() + 5.0; z < subject.top_mm() - 2.0; z += pitch, ++level) {
    for (std::uint16_t sensor = 0; sensor < 180; ++sensor) {
      const double theta = kTwoPi * sensor / 180.0;
      const Eigen::Vector3d inward = -PointFromCylindrical(theta, 1.0, 0.0);
      const auto hit = subject.Cast({PointFromCylindrical(theta, kRingRadius, z), inward}, 0.0, kRingRadius - 1e-6);
      if (!hit) continue;
      SurfaceSample sample;
      sample.theta = theta;
      sample.z = z;
      sample.radius = kRingRadius - hit->distance_mm;
      sample.ray_direction = inward.cast<float>();
      sample.level = level;
      sample.sensor = sensor;
      samples.push_back(sample);
    }
  }
  return samples;
}

const SectionRegion* Region(const std::vector<SectionRegion>& regions, const std::string& name) {
  const auto found =
      std::find_if(regions.begin(), regions.end(), [&](const SectionRegion& region) { return region.name == name; });
  return found == regions.end() ? nullptr : &*found;
}

class SegmentsOfAPerson : public testing::TestWithParam<sim::PersonOptions> {};

TEST_P(SegmentsOfAPerson, BeginAtTheCrotchAndTheArmpits) {
  constexpr double kPitch = 5.0;
  const sim::ParametricBody person = sim::MakePerson(GetParam());
  const auto samples = Scan(person, kPitch);
  const SectionTopology topology = FindSectionTopology(samples, SampleGrid(samples));
  const SectionRegion* legs = Region(topology.regions, "legs");
  ASSERT_NE(legs, nullptr);
  ASSERT_TRUE(person.heights().crotch_mm && person.heights().armpit_mm);
  // Just below the crotch, thighs may still hide the air between them: a part in twenty of the stature.
  EXPECT_LE(legs->z_max, *person.heights().crotch_mm + kPitch);
  EXPECT_GE(legs->z_max, *person.heights().crotch_mm - 0.05 * person.top_mm());
  EXPECT_LE(legs->z_min, person.bottom_mm() + 4.0 * kPitch);
  for (const char* name : {"right arm", "left arm"}) {
    const SectionRegion* arm = Region(topology.regions, name);
    ASSERT_NE(arm, nullptr) << name;
    // Just above the armpit, the groove on either side of the arm still parts it from the trunk as rays see it.
    EXPECT_GE(arm->z_max, *person.heights().armpit_mm - 2.0 * kPitch) << name;
    EXPECT_LE(arm->z_max, *person.heights().armpit_mm + 0.05 * person.top_mm()) << name;
  }
  EXPECT_EQ(topology.parts.size(), 4U);
}

INSTANTIATE_TEST_SUITE_P(People, SegmentsOfAPerson,
                         testing::Values(sim::PersonOptions{}, sim::PersonOptions{1500.0, 0.9, {-8.0, 10.0, -0.1}},
                                         sim::PersonOptions{1900.0, 1.0, {3.0, 12.0, 0.2}}));

/// The folder with the shared scans: $ANNULUS_DATA, else ../shared/data beside the project.
std::filesystem::path DataFolder() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): tests read the environment from one thread.
  const char* const given = std::getenv("ANNULUS_DATA");
  return given != nullptr ? given : std::filesystem::path(test::SourceFolder()) / ".." / "shared" / "data";
}

/// Whether all cells of a segment within three of (theta, z) were seen: away from edges.
bool IsInside(const SurfaceSegment& segment, double theta, double z) {
  const KnowledgeMap& map = segment.knowledge;
  const double across = kTwoPi / static_cast<double>(map.columns());
  const double up = (map.z_max() - map.z_min()) / static_cast<double>(map.rows());
  for (int row = -3; row <= 3; ++row) {
    for (int column = -3; column <= 3; ++column) {
      if (map.At(WrapAngle(theta + column * across), z + row * up) != Knowledge::kMeasured) return false;
    }
  }
  return true;
}

class SegmentsOfASharedScan : public testing::TestWithParam<const char*> {};

TEST_P(SegmentsOfASharedScan, AreWithinHalfAMillimetreAwayFromEdges) {
  const std::filesystem::path folder = DataFolder();
  const std::string name = GetParam();
  if (!std::filesystem::exists(folder / (name + "_noisy.csv.gz"))) GTEST_SKIP() << "no data";
  PosixStorage storage;
  const auto noisy = ReadCsvScan(storage, (folder / (name + "_noisy.csv.gz")).string());
  const auto clean = ReadCsvScan(storage, (folder / (name + "_clean.csv.gz")).string());
  ASSERT_TRUE(noisy.has_value() && clean.has_value());
  const auto fit = FitBody(BuildSamples(*noisy), {}, {});
  ASSERT_TRUE(fit.has_value()) << fit.error().Text();
  const std::vector<SurfaceSample> truth = BuildSamples(*clean);
  const SectionTopology topology = FindSectionTopology(truth, SampleGrid(truth));
  for (const SurfaceSegment& segment : fit->model.segments) {
    const auto part = std::find_if(topology.parts.begin(), topology.parts.end(),
                                   [&](const SectionPart& p) { return p.name == segment.name; });
    if (part == topology.parts.end()) continue;  // the trunk: real_data_test.py
    std::vector<SurfaceSample> limb;
    for (const std::size_t k : part->samples) limb.push_back(truth[k]);
    double squares = 0.0;
    double all_squares = 0.0;
    std::size_t inside = 0;
    std::size_t known = 0;
    for (const SurfaceSample& sample : SamplesAboutAxis(limb, segment.axis)) {
      if (segment.knowledge.At(sample.theta, sample.z) == Knowledge::kUnknown) continue;
      const double error = sample.radius - segment.surface.Radius(sample.theta, sample.z);
      all_squares += error * error;
      ++known;
      if (!IsInside(segment, sample.theta, sample.z)) continue;
      squares += error * error;
      ++inside;
    }
    ASSERT_GT(inside, 100U) << segment.name;
    const double rms = std::sqrt(squares / static_cast<double>(inside));
    std::cout << "  " << name << ", " << segment.name << ": " << known << " of " << limb.size()
              << " returns known, RMS " << std::sqrt(all_squares / static_cast<double>(known))
              << " mm; away from edges " << inside << ", RMS " << rms << " mm\n";
    EXPECT_LE(rms, 0.5) << segment.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, SegmentsOfASharedScan, testing::Values("body_mean_female", "body_arms_mh_female"));

}  // namespace
}  // namespace annulus
