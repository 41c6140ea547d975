#include "station/worn_lenses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "modeling/glasses/frame_library.h"
#include "modeling/glasses/glasses_fit.h"
#include "modeling/glasses/rim.h"
#include "render/lens_solid.h"
#include "sim/head.h"
#include "station/lens_choice.h"
#include "tests/modeling_glasses_fit/test_frames.h"
#include "tests/modeling_glasses_fit/true_head.h"
#include "tests/modeling_lens/lens_orders.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

using Eigen::Vector3d;

/// A frame that nobody wears.
GlassesSource Unworn(const FrameDesign& design) {
  FrameFile file;
  file.design = design;
  return {file, std::nullopt, BuildFrame(design, StandardAdjustment(design)).value()};
}

/// Every style of the library in a size that is sold; the paper's examples as wide as a usual face needs.
std::vector<FrameDesign> AllStyles() {
  std::vector<FrameDesign> designs;
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    designs.push_back(style.sizes.empty() ? ScaledToWidth(style.design, 52.0)
                                          : test::LibraryDesign(style.name, style.sizes.front().name));
  }
  return designs;
}

WornLensSet LensesWith(const GlassesSource& source, double power) {
  LensLook look;
  look.power = power;
  auto set = WornLenses(source, look, "test");
  EXPECT_TRUE(set.has_value()) << (set ? "" : set.error().Text());
  return set ? *set : WornLensSet{};
}

/// A mirrored at x = 0 of the frame frame.
Vector3d Mirror(const Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

/// The lens frame's place of a point of the frame frame.
Vector3d InLens(const SolidLens& lens, const Vector3d& p) { return lens.station_from_lens.inverse() * p; }

TEST(WornLenses, TheirEdgesLieInTheGrooveOfEveryStyleAllRound) {
  // LensPoint is where the frame has the groove's bottom (of a rimless frame its lens' outline).
  const std::vector<FrameDesign> designs = AllStyles();
  EXPECT_GE(designs.size(), 31U);
  for (const FrameDesign& design : designs) {
    const GlassesSource source = Unworn(design);
    for (const double power : {0.0, -4.0, 3.0}) {
      SCOPED_TRACE(design.style + ", " + std::to_string(power) + " D");
      const WornLensSet set = LensesWith(source, power);
      ASSERT_EQ(set.lenses.size(), 2U);
      double aside = 0.0;
      double off_the_edge = -1e9;
      for (std::size_t side = 0; side < 2; ++side) {
        const SolidLens& lens = set.lenses[side];
        ASSERT_TRUE(LensSolid::Make(lens).has_value());
        for (std::size_t k = 0; k < 4; ++k) {
          for (int step = 0; step < 20; ++step) {
            Vector3d groove = LensPoint(source.frame.rim, k, step / 20.0);
            if (side == 1) groove = Mirror(groove);
            const Vector3d p = InLens(lens, groove);
            // Sideways: on the outline. Along the axis: between the edge's front and back.
            const auto& points = lens.outline.points;
            double nearest = 1e9;
            for (const Eigen::Vector2d& q : points) nearest = std::min(nearest, (q - p.head<2>()).norm());
            aside = std::max(aside, nearest);
            const double front = lens.form.front.Sag(p.x(), p.y());
            const double back = lens.form.back.Sag(p.x(), p.y());
            off_the_edge = std::max({off_the_edge, p.z() - front, back - p.z()});
          }
        }
      }
      EXPECT_LT(aside, 1e-9) << "the groove's points are among the outline's";
      const bool is_said = std::any_of(set.notes.begin(), set.notes.end(), [](const std::string& note) {
        return note.find("leaves the lens' edge") != std::string::npos;
      });
      // A curved lens in a flat rim, or a flat one in a curved rim: its edge is as thin as 1 mm, the rim must give way.
      EXPECT_LT(off_the_edge, is_said ? 1.5 : 0.11);
      EXPECT_GT(off_the_edge, is_said ? 0.09 : -10.0);
      if (power < 0.0 && !is_said) {
        EXPECT_LT(off_the_edge, -0.4) << "a minus lens has edge enough";
      }
    }
  }
}

TEST(WornLenses, LeftAndRightAreMirrorImages) {
  for (const FrameDesign& design : {test::LibraryDesign("wellington", "medium"), test::LibraryDesign("panto", "medium"),
                                    test::LibraryDesign("rimless-oval", "medium")}) {
    const WornLensSet set = LensesWith(Unworn(design), -3.0);
    ASSERT_EQ(set.lenses.size(), 2U);
    const LensSolid right = LensSolid::Make(set.lenses[0]).value();
    const LensSolid left = LensSolid::Make(set.lenses[1]).value();
    std::size_t met = 0;
    for (double x = 5.0; x < 70.0; x += 2.3) {
      for (double z = -25.0; z < 25.0; z += 2.1) {
        const Vector3d eye(x + 3.0, 300.0, z - 5.0);
        const Vector3d direction = (Vector3d(x, 0.0, z) - eye).normalized();
        const auto a = right.Next({eye, direction});
        const auto b = left.Next({Mirror(eye), Mirror(direction)});
        ASSERT_EQ(a.has_value(), b.has_value());
        if (!a) continue;
        ++met;
        EXPECT_LT((a->point - Mirror(b->point)).norm(), 1e-6);
        EXPECT_LT((a->normal - Mirror(b->normal)).norm(), 1e-6);
      }
    }
    EXPECT_GT(met, 150U);
  }
}

TEST(WornLenses, StandUprightBeforeTheEyesWithTheirFrontsForward) {
  const GlassesSource source = Unworn(test::LibraryDesign("wellington", "medium"));
  const WornLensSet set = LensesWith(source, -2.0);
  ASSERT_EQ(set.lenses.size(), 2U);
  EXPECT_GT(set.lenses[0].station_from_lens.translation().x(), 0.0) << "the wearer's right is +x";
  EXPECT_LT(set.lenses[1].station_from_lens.translation().x(), 0.0);
  for (const SolidLens& lens : set.lenses) {
    const Eigen::Matrix3d turn = lens.station_from_lens.linear();
    EXPECT_GT(turn.col(2).y(), 0.9) << "z is forward";
    EXPECT_GT(turn.col(1).z(), 0.9) << "y is up";
    EXPECT_LT(turn.col(0).x(), -0.9) << "x is the wearer's left";
    // Face form: the temporal side is nearer to the face.
    const double outward = lens.station_from_lens.translation().x() > 0.0 ? 1.0 : -1.0;
    EXPECT_GE(outward * turn.col(2).x(), -1e-12);
  }
  EXPECT_EQ(set.lenses[0].group, "lens_right");
  EXPECT_EQ(set.lenses[1].group, "lens_left");
}

TEST(WornLenses, WithoutAnOrderAPlanoLensHasABaseOfFourDioptresAndNoPower) {
  const WornLensSet set = LensesWith(Unworn(test::LibraryDesign("wellington", "medium")), 0.0);
  ASSERT_EQ(set.lenses.size(), 2U);
  EXPECT_DOUBLE_EQ(set.design.right.base, 4.0);
  EXPECT_NEAR(set.design.right.front_radius, 1000.0 * 0.498 / 4.0, 1e-6);
  EXPECT_NEAR(TraceFocimeter(set.lenses[0].form).value().power.norm(), 0.0, 1e-6);
  const WornLensSet strong = LensesWith(Unworn(test::LibraryDesign("wellington", "medium")), -8.0);
  EXPECT_EQ(strong.design.material.name, "1.67");
  // Its index is that of the d line: (n_d − 1)/(n_e − 1) of the ordered power.
  const double share = (strong.lenses[0].form.index - 1.0) / 0.67;
  EXPECT_NEAR(share, 0.9924, 0.0002);  // Cauchy's law by hand: n_d = 1.67 − 0.00512
  EXPECT_NEAR(TraceFocimeter(strong.lenses[0].form).value().power(0, 0), -8.0 * share, 0.01);
}

TEST(WornLenses, APowerOutOfRangeIsRefused) {
  const GlassesSource source = Unworn(test::LibraryDesign("wellington", "medium"));
  for (const double power : {31.0, -31.0, std::nan("")}) {
    LensLook look;
    look.power = power;
    EXPECT_FALSE(WornLenses(source, look, "test").has_value()) << power;
  }
}

TEST(WornLenses, AnOrderThatIsKeptMakesTheLensesOfTheExport) {
  const FrameDesign design = test::LibraryDesign("wellington", "medium");
  GlassesSource source = Unworn(design);
  WornFile file;
  file.worn.design = design;
  file.worn.adjustment = StandardAdjustment(design);
  file.worn.station_from_frame = Eigen::Translation3d(3.0, 90.0, 1600.0) * Eigen::AngleAxisd(0.1, Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(-0.15, Vector3d::UnitX());
  Prescription order = test::Order(-5.0, 2.0);
  order.right.cylinder = -1.5;
  order.right.axis_deg = 30.0;
  KeepOrder(order, {"1.60", 4.5, std::nullopt, std::nullopt, true}, file);
  source.worn = file;
  const WornLensSet set = LensesWith(source, 0.0);
  ASSERT_EQ(set.lenses.size(), 2U);
  EXPECT_DOUBLE_EQ(set.design.right.base, 4.5);
  EXPECT_EQ(set.design.material.name, "1.60");
  // At the line of the order's index a focimeter reads the order; axis 30° in the front view.
  LensForm as_ordered = set.lenses[0].form;
  as_ordered.index = set.design.material.index;
  const auto read = SpheroCylinderFrom(TraceFocimeter(as_ordered).value().power);
  EXPECT_NEAR(read.sphere, -5.0, 1e-6);
  EXPECT_NEAR(read.cylinder, -1.5, 1e-6);
  EXPECT_NEAR(DegreesFromRadians(read.axis), 30.0, 1e-6);
  EXPECT_NEAR(TraceFocimeter(set.lenses[1].form).value().power(0, 0), 2.0, 0.03);
  // Worn where the frame is worn.
  const WornLensSet unworn = LensesWith(Unworn(design), 0.0);
  EXPECT_TRUE(set.lenses[0].station_from_lens.linear().isApprox(
      file.worn.station_from_frame.linear() * unworn.lenses[0].station_from_lens.linear(), 1e-12));

  source.worn->SetSection("lens_choice", R"({"material": 3})");
  EXPECT_FALSE(WornLenses(source, {}, "worn.json").has_value());
}

TEST(WornLenses, AGradientRunsOverTheLensBox) {
  LensLook look;
  look.transmittance = 0.3;
  look.lower_transmittance = 0.8;
  const GlassesSource source = Unworn(test::LibraryDesign("wellington", "medium"));
  const auto set = WornLenses(source, look, "test");
  ASSERT_TRUE(set.has_value());
  for (const SolidLens& lens : set->lenses) {
    const LensBox box = BoxOf(lens.outline);
    EXPECT_NEAR(lens.finish.gradient_from, box.centre.y() + 0.5 * box.b, 1e-9);
    EXPECT_NEAR(lens.finish.gradient_to, box.centre.y() - 0.5 * box.b, 1e-9);
  }
}

/// How far a lens reaches behind the plane of its rim, mm.
double BehindRim(const GlassesSource& source, const SolidLens& lens, std::size_t side) {
  double behind = 0.0;
  for (const Eigen::Vector2d& p : lens.outline.points) {
    const Vector3d back(p.x(), p.y(), lens.form.back.Sag(p.x(), p.y()));
    const Vector3d p_in_frame = source.worn->worn.station_from_frame.inverse() * (lens.station_from_lens * back);
    const Vector3d right = side == 0 ? p_in_frame : Mirror(p_in_frame);
    behind = std::max(behind, -(source.frame.rim.frame_from_rim.inverse() * right).y());
  }
  return behind;
}

TEST(WornLenses, StayOutOfTheHeadThatWearsThem) {
  const sim::ParametricBody body = sim::MakeHead({});
  const SurfaceModel model = test::HeadSurface(body);
  const auto measured = MeasuredSurface::FromModel(model);
  ASSERT_TRUE(measured.has_value());
  const auto wearer = WearerHead::Look(*measured, {});
  ASSERT_TRUE(wearer.has_value());
  const test::TrueHead head(body);
  for (const char* style : {"wellington", "rimless-oval"}) {
    const FrameDesign design = test::LibraryDesign(style, "medium");
    for (const double power : {-6.0, 5.0}) {
      // As a fit with an order: the lens follows the fit and the fit the lens.
      GlassesFitOptions options;
      options.detail = FitDetail::kRanking;
      WornLensSet set;
      for (int round = 0; round < 3; ++round) {
        const auto fit = FitGlasses(*wearer, design, options);
        ASSERT_TRUE(fit.has_value());
        FrameFile file;
        file.design = fit->worn.design;
        file.adjustment = fit->worn.adjustment;
        const GlassesSource source{file, WornFile{fit->worn, {}, {}}, BuildWornFrame(fit->worn).value()};
        set = LensesWith(source, power);
        for (const std::size_t side : {0U, 1U}) options.lens_back[side] = BehindRim(source, set.lenses[side], side);
      }
      double nearest = 1e9;
      for (const SolidLens& lens : set.lenses) {
        for (const Eigen::Vector2d& point : lens.outline.points) {
          for (const double share : {0.3, 0.7, 1.0}) {
            const Eigen::Vector2d p = share * point;
            const double z = lens.form.back.Sag(p.x(), p.y());
            nearest = std::min(nearest, head.RadialGap(lens.station_from_lens * Vector3d(p.x(), p.y(), z)));
          }
        }
      }
      EXPECT_GT(nearest, 0.0) << style << ", " << power << " D";
    }
  }
}

}  // namespace
}  // namespace annulus
