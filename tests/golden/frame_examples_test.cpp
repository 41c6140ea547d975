/// Paper 000's frame examples 1–4: their numbers against frame_examples.py, which computes them from the paper's text
/// alone, and their pictures against stored ones, which were looked at beside the paper's descriptions.
///
/// Where a change is meant to move the pictures, store them again from the repository's folder with
///   ANNULUS_UPDATE_GOLDEN=1 build/release/golden_test
/// look at them, and say in the commit what moved. The numbers come from `frame_examples.py --update` only.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "modeling/bezier/patch_shell.h"
#include "modeling/glasses/boxing.h"
#include "modeling/glasses/frame_library.h"
#include "render/png.h"
#include "station/design_picture.h"
#include "tests/golden/stored_picture.h"
#include "tests/support/folders.h"

namespace annulus {
namespace {

using Json = nlohmann::json;

constexpr int kPictureWidth = 300;
/// Our outline has 720 points, the script's 80,000: lengths between points are short by at most their sagitta.
constexpr double kSampling = 2e-3;

std::string Path(const std::string& name) { return test::SourceFolder() + "/tests/golden/" + name; }

Frame Build(const std::string& name) {
  const FrameDesign& design = BuiltInFrameLibrary().Find(name).value()->design;
  return BuildFrame(design, StandardAdjustment(design)).value();
}

double VolumeOf(const Frame& frame, const std::string& name) {
  for (const FrameBody& body : FrameBodies(frame)) {
    for (const PatchShell& shell : body.shells) {
      if (shell.name == name) return Volume(shell);
    }
  }
  return 0.0;
}

class FrameExample : public testing::TestWithParam<const char*> {};

TEST_P(FrameExample, HasTheNumbersOfThePapersGeometry) {
  std::ifstream file(Path("frame_examples.json"));
  ASSERT_TRUE(file);
  const Json expected = Json::parse(file).at(GetParam());
  const Frame frame = Build(GetParam());
  const FrameParameters& p = frame.design.parameters;
  EXPECT_NEAR(p.height, expected.at("l2_mm"), 1e-9);
  EXPECT_NEAR(p.upper_thickness, expected.at("d1_mm"), 1e-9);
  EXPECT_NEAR(p.lower_thickness, expected.at("d2_mm"), 1e-9);
  const std::vector<double> cuts = expected.at("cuts_mm");
  EXPECT_NEAR(p.upper_outer, cuts[0], 1e-9);
  EXPECT_NEAR(p.upper_inner, cuts[1], 1e-9);
  EXPECT_NEAR(p.lower_inner, cuts[2], 1e-9);
  EXPECT_NEAR(p.lower_outer, cuts[3], 1e-9);

  const FrameBoxing boxing = BoxingOf(frame);
  EXPECT_NEAR(boxing.a, expected.at("a_mm"), kSampling);
  EXPECT_NEAR(boxing.b, expected.at("b_mm"), kSampling);
  EXPECT_NEAR(boxing.ed, expected.at("ed_mm"), kSampling);
  EXPECT_NEAR(boxing.dbl, expected.at("dbl_mm"), kSampling);
  EXPECT_NEAR(boxing.circumference, expected.at("circumference_mm"), 3 * kSampling);
  const std::vector<double> radii = expected.at("radii_mm");
  const std::vector<double> ours = RadiiOf(LensOutlineOf(frame, Eye::kRight), radii.size());
  for (std::size_t k = 0; k < radii.size(); ++k) EXPECT_NEAR(ours[k], radii[k], kSampling) << 10 * k << " degrees";
}

TEST_P(FrameExample, HasTheVolumesOfThePapersGeometry) {
  std::ifstream file(Path("frame_examples.json"));
  ASSERT_TRUE(file);
  const Json expected = Json::parse(file).at(GetParam());
  const Frame frame = Build(GetParam());
  EXPECT_NEAR(VolumeOf(frame, "rim_right"), expected.at("rim_volume_mm3"), 1e-5);
  EXPECT_NEAR(VolumeOf(frame, "rim_left"), expected.at("rim_volume_mm3"), 1e-5);
  EXPECT_NEAR(VolumeOf(frame, "bridge"), expected.at("bridge_volume_mm3"), 1e-5);
}

TEST_P(FrameExample, LooksAsItDid) {
  const auto image = DrawDesign(Build(GetParam()), DesignMaterial::kAcetate, kPictureWidth, {});
  ASSERT_TRUE(image) << image.error().Text();
  test::ExpectStoredPicture(*image, Path(std::string("frame_") + GetParam() + ".png"));
}

INSTANTIATE_TEST_SUITE_P(Paper000, FrameExample, testing::Values("example1", "example2", "example3", "example4"),
                         [](const auto& parameter) { return std::string(parameter.param); });

}  // namespace
}  // namespace annulus
