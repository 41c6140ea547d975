#include "station/inside_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "modeling/glasses/frame_library.h"
#include "station/inside_map.h"

namespace annulus {
namespace {

/// A level, symmetric face, PD 62 mm.
FacePoints LevelFace() {
  FacePoints face;
  face.eye_right.position = {31, 80, 1580};
  face.eye_left.position = {-31, 80, 1580};
  face.ear_right.position = {76, 4, 1584};
  face.ear_left.position = {-76, 4, 1584};
  face.forehead.position = {0, 99, 1620};
  face.sellion.position = {0, 94, 1588};
  face.pronasale.position = {0, 113, 1550};
  return face;
}

GlassesSource WornSource() {
  const FrameDesign design(BuiltInFrameLibrary().Find("example3").value()->design.parameters);
  const auto worn = PlaceFrame(design, LevelFace());
  EXPECT_TRUE(worn) << (worn ? "" : worn.error().Text());
  const auto frame = BuildWornFrame(*worn);
  EXPECT_TRUE(frame);
  GlassesSource source{{worn->design, std::nullopt, worn->adjustment}, WornFile{}, *frame};
  source.worn->worn = *worn;
  return source;
}

GlassesExportOptions Ordered(double sphere) {
  GlassesExportOptions options;
  Prescription order;
  order.date = "2026-05-04";
  order.prescriber = "Dr. Example";
  order.right.sphere = order.left.sphere = sphere;
  options.prescription = order;
  return options;
}

InsideGlasses Inside(const GlassesExportOptions& options) {
  auto glasses = InsideGlassesOf(WornSource(), options);
  EXPECT_TRUE(glasses) << (glasses ? "" : glasses.error().Text());
  return std::move(*glasses);
}

TEST(InsideView, ReadsDirectionsOfGaze) {
  const auto gazes = ParseGazes("0,0;20,-25.5;-3,1");
  ASSERT_TRUE(gazes);
  ASSERT_EQ(gazes->size(), 3U);
  EXPECT_NEAR((*gazes)[1].left, RadiansFromDegrees(20.0), 1e-12);
  EXPECT_NEAR((*gazes)[1].up, RadiansFromDegrees(-25.5), 1e-12);
  for (const char* bad : {"", "1", "1,", ",1", "1,2;", "1,2 ", "61,0", "0,-61", "nan,0", "1,2;3", "x",
                          "0,0;0,0;0,0;0,0;0,0;0,0;0,0;0,0;0,0"}) {
    EXPECT_FALSE(ParseGazes(bad)) << bad;
  }
}

TEST(InsideView, TheLensSitsInItsRim) {
  const GlassesSource source = WornSource();
  const auto glasses = InsideGlassesOf(source, Ordered(-4.0));
  ASSERT_TRUE(glasses);
  for (const Eye eye : {Eye::kRight, Eye::kLeft}) {
    const InsideEye& inside = glasses->of(eye);
    const Eigen::Vector3d rim = eye == Eye::kRight ? source.frame.rim_centre_right() : source.frame.rim_centre_left();
    const Eigen::Vector3d in_lens = inside.lens_from_frame * rim;
    EXPECT_NEAR(in_lens.head<2>().norm(), 0.0, 1e-9);
    // The rim's plane lies half way between the front's and the back's edge, in the mean of all round.
    double middle = 0.0;
    const std::vector<double> radii = RadiiOf(inside.outline, 360);
    for (std::size_t i = 0; i < radii.size(); ++i) {
      const double around = RadiansFromDegrees(static_cast<double>(i));
      const Eigen::Vector2d edge =
          BoxOf(inside.outline).centre + radii[i] * Eigen::Vector2d(std::cos(around), std::sin(around));
      middle += 0.5 * (inside.form.front.Sag(edge.x(), edge.y()) + inside.form.back.Sag(edge.x(), edge.y())) / 360.0;
    }
    EXPECT_NEAR(in_lens.z(), middle, 1e-6);
    EXPECT_NEAR(inside.lens_from_frame.linear().determinant(), 1.0, 1e-12);
    EXPECT_LT(inside.lens_from_frame.linear()(0, 0), -0.99);  // the wearer's right is the lens' −x
  }
}

TEST(InsideView, BothEyesOfASymmetricFaceAreMirrorImagesAndTheRimLimitsThem) {
  const InsideGlasses glasses = Inside(Ordered(-4.0));
  const FieldLimits right = FieldLimitsOf(glasses.right.Sight());
  const FieldLimits left = FieldLimitsOf(glasses.left.Sight());
  EXPECT_NEAR(right.right.gaze, left.left.gaze, 1e-3);
  EXPECT_NEAR(right.left.gaze, left.right.gaze, 1e-3);
  EXPECT_NEAR(right.down.gaze, left.down.gaze, 1e-3);
  EXPECT_GT(right.right.gaze, RadiansFromDegrees(25.0));
  const LensSight without_frame(glasses.right.form, glasses.right.outline, glasses.right.pose, nullptr);
  EXPECT_LE(right.gaze_solid_angle, FieldLimitsOf(without_frame).gaze_solid_angle);
}

TEST(InsideView, WithoutAnOrderTheLensesArePlanoAndThatIsSaid) {
  const InsideGlasses glasses = Inside({});
  ASSERT_EQ(glasses.notes.size(), 1U);
  EXPECT_NE(glasses.notes[0].find("plano"), std::string::npos);
  const FieldPoint ahead = FieldPointAt(glasses.left.Sight(), glasses.left.goal, {});
  ASSERT_EQ(ahead.path, SightPath::kLens);
  EXPECT_LT(ahead.worst_error, 1e-3);
  EXPECT_NEAR(glasses.left.correction.norm(), 0.0, 1e-12);
}

TEST(InsideView, AnAdditionIsSaidNotToBeInTheLens) {
  GlassesExportOptions options = Ordered(-1.0);
  options.prescription->right.add = 2.0;
  const InsideGlasses glasses = Inside(options);
  ASSERT_EQ(glasses.notes.size(), 1U);
  EXPECT_NE(glasses.notes[0].find("right eye: ADD +2.00 D is carried"), std::string::npos) << glasses.notes[0];
}

TEST(InsideView, ADesignThatNobodyWearsIsRefused) {
  GlassesSource source = WornSource();
  source.worn.reset();
  const auto glasses = InsideGlassesOf(source, {});
  ASSERT_FALSE(glasses);
  EXPECT_NE(glasses.error().Text().find("nobody wears them"), std::string::npos);
}

TEST(InsideView, TheReportHoldsTheFieldInDegreesAndDioptres) {
  const InsideGlasses glasses = Inside(Ordered(-4.0));
  const auto report = InsideReport(glasses, {Eye::kRight}, {Gaze{}, Gaze{0.3, 0.0}});
  EXPECT_EQ(report["format"], "annulus-inside-view");
  EXPECT_FALSE(report.contains("left"));
  const auto& right = report["right"];
  EXPECT_EQ(right["order"]["sph_d"], -4.0);
  EXPECT_NEAR(right["gaze"][0]["mean_error_d"].get<double>(), 0.0, 1e-4);  // compensated as worn
  EXPECT_NEAR(right["gaze"][1]["left_deg"].get<double>(), DegreesFromRadians(0.3), 1e-9);
  EXPECT_GT(right["gaze"][1]["astigmatism_d"].get<double>(), 0.0);
  // A minus lens: the world is wider than the eye's turn, so its edge shows things twice.
  EXPECT_GT(right["field"]["right"]["object_deg"].get<double>(), right["field"]["right"]["gaze_deg"].get<double>());
  EXPECT_GE(right["within"]["1_d"].get<double>(), right["within"]["0.25_d"].get<double>());
  EXPECT_EQ(right["grid"]["points"].size(), 21U * 19U);
  EXPECT_EQ(right["grid"]["points"][0].contains("mean_error_d"), right["grid"]["points"][0]["path"] == "lens");
}

TEST(InsideView, APictureHasARowForEachGazeAndAColumnForEachEye) {
  const InsideGlasses glasses = Inside(Ordered(-4.0));
  InsideViewOptions options;
  options.view.width = 80;
  options.view.height = 60;
  options.view.samples = 4;
  options.gazes = {Gaze{}, Gaze{0.0, -0.3}};
  const auto image = DrawInsideView(glasses, nullptr, options, {});
  ASSERT_TRUE(image) << image.error().Text();
  EXPECT_EQ(image->width, 2 * 80 + 6);
  EXPECT_EQ(image->height, 2 * (60 + 24) + 6);
  for (const LinearRgb& pixel : image->rgb) ASSERT_TRUE(pixel.allFinite());
  options.eyes.clear();
  EXPECT_FALSE(DrawInsideView(glasses, nullptr, options, {}));
}

TEST(InsideMap, ShowsTheLeftEyeAtTheLeftAndEachEyesTempleOutwards) {
  const InsideGlasses glasses = Inside(Ordered(-6.0));
  const auto image = DrawInsideMap(glasses, {Eye::kRight, Eye::kLeft}, {Gaze{0.2, 0.1}});
  ASSERT_TRUE(image) << image.error().Text();
  // What is seen beside the lens is light grey; towards the nose the frame's bridge and the other rim stand in the way.
  const LinearRgb beside = LinearFromHex(0xededed);
  const auto beside_between = [&](int from, int to) {
    int count = 0;
    for (int y = 110; y < 420; ++y) {
      for (int x = from; x < to; ++x) count += (image->rgb[image->Index(x, y)] - beside).norm() < 1e-3F ? 1 : 0;
    }
    return count;
  };
  const int panel = 396;
  const int left_panel = 58;
  const int right_panel = left_panel + panel + 24;
  EXPECT_GT(beside_between(left_panel, left_panel + 70), 0);
  EXPECT_GT(beside_between(right_panel + panel - 70, right_panel + panel), 0);
  const auto one = DrawInsideMap(glasses, {Eye::kLeft}, {});
  ASSERT_TRUE(one);
  EXPECT_LT(one->width, image->width);
  EXPECT_FALSE(DrawInsideMap(glasses, {}, {}));
}

}  // namespace
}  // namespace annulus
