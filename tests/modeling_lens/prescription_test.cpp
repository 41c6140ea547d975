#include "modeling/glasses/prescription.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "base/units.h"
#include "modeling/glasses/lens_power.h"

namespace annulus {
namespace {

using testing::HasSubstr;

Prescription Usual() {
  Prescription rx;
  rx.date = "2026-02-28";
  rx.prescriber = "Dr. Example";
  rx.right = {-4.0, -0.75, 90.0, {1.0, 0.5}, 2.0, 31.5, 20.0};
  rx.left = {-3.5, 0.0, {}, {}, 2.0, 32.0, 20.5};
  rx.refracted_vertex = 12.0;
  return rx;
}

std::string Complaint(const Prescription& rx) {
  const Status status = Validate(rx);
  return status ? "valid" : status.error().Text();
}

TEST(Prescription, AUsualOneIsValid) { EXPECT_EQ(Complaint(Usual()), "valid"); }

TEST(Prescription, ImpossibleOrdersAreRefusedWithTheReason) {
  struct Case {
    std::function<void(Prescription&)> spoil;
    const char* reason;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Case cases[] = {
      {[](auto& rx) { rx.right.sphere = -30.25; }, "right SPH is -30.25 D, outside -30 to 30 D"},
      {[](auto& rx) { rx.left.sphere = 31; }, "left SPH is 31 D"},
      {[nan](auto& rx) { rx.left.sphere = nan; }, "left SPH is nan D"},
      {[](auto& rx) { rx.right.cylinder = 15.25; }, "right CYL is 15.25 D, outside -15 to 15 D"},
      {[](auto& rx) { rx.right.sphere = -29.5; }, "right SPH + CYL is -30.25 D"},
      {[](auto& rx) { rx.right.axis_deg.reset(); }, "right CYL is -0.75 D but it has no axis"},
      {[](auto& rx) { rx.right.axis_deg = 181; }, "right axis is 181 °, outside 0 to 180 °"},
      {[](auto& rx) { rx.right.axis_deg = -1; }, "right axis is -1 °"},
      {[](auto& rx) { rx.right.add = 4.25; }, "right ADD is 4.25 D, outside 0.25 to 4 D"},
      {[](auto& rx) { rx.left.add = 0; }, "left ADD is 0 D"},
      {[](auto& rx) {
         rx.right.prism = {12.0, 17.0};
       },
       "right prism is 20.8"},
      {[nan](auto& rx) { rx.left.prism.up = nan; }, "left prism is nan cm/m, above 20 cm/m"},
      {[](auto& rx) { rx.left.pd = 63; }, "left PD is 63 mm, outside 20 to 45 mm"},
      {[](auto& rx) { rx.right.height = 2; }, "right fitting height is 2 mm, outside 5 to 60 mm"},
      {[](auto& rx) { rx.refracted_vertex = 0; }, "vertex distance of the refraction is 0 mm, outside 5 to 25 mm"},
      {[](auto& rx) { rx.date = "28.02.2026"; }, "the date '28.02.2026' is not written YYYY-MM-DD"},
      {[](auto& rx) { rx.date = "2026-2-028"; }, "is not written YYYY-MM-DD"},
      {[](auto& rx) { rx.date = "2026-02-29"; }, "the date 2026-02-29 does not exist"},
      {[](auto& rx) { rx.date = "2100-02-29"; }, "does not exist"},
      {[](auto& rx) { rx.date = "2026-13-01"; }, "does not exist"},
      {[](auto& rx) { rx.date = "2026-04-31"; }, "does not exist"},
      {[](auto& rx) { rx.date = "1026-04-30"; }, "does not exist"},
      {[](auto& rx) { rx.prescriber.clear(); }, "the prescriber's name has 0 bytes"},
      {[](auto& rx) { rx.centration_confirmed_by = std::string(201, 'x'); }, "confirmed the centration"},
  };
  for (const Case& spoiled : cases) {
    Prescription rx = Usual();
    spoiled.spoil(rx);
    EXPECT_THAT(Complaint(rx), HasSubstr(spoiled.reason));
  }
}

TEST(Prescription, LeapDaysExistWhereTheyDo) {
  for (const char* date : {"2024-02-29", "2000-02-29", "2026-12-31", "1999-01-01"}) {
    Prescription rx = Usual();
    rx.date = date;
    EXPECT_EQ(Complaint(rx), "valid") << date;
  }
}

TEST(Prescription, TransposesTheTextbookExample) {
  // −2.00 −1.50 × 180 is −3.50 +1.50 × 90.
  const EyePrescription plus = InPlusCylinder({-2.0, -1.5, 180.0, {}, {}, {}, {}});
  EXPECT_EQ(plus.sphere, -3.5);
  EXPECT_EQ(plus.cylinder, 1.5);
  EXPECT_EQ(plus.axis_deg, 90.0);
}

TEST(Prescription, TranspositionRoundTripsExactlyOnTheWholeGrid) {
  // Every quarter and eighth dioptre, also written 0.12, 0.37 …, and every whole axis.
  std::size_t count = 0;
  for (int sphere = -1000; sphere <= 1000; sphere += 37) {
    for (int cylinder = -600; cylinder <= 600; cylinder += 25) {
      for (int axis = 1; axis <= 180; ++axis) {
        const EyePrescription order{sphere / 100.0, cylinder / 100.0, static_cast<double>(axis), {}, {}, {}, {}};
        const EyePrescription other = Transposed(order);
        const EyePrescription again = Transposed(other);
        ASSERT_EQ(again, order) << order.sphere << " " << order.cylinder << " x " << axis;
        ASSERT_LE(InMinusCylinder(order).cylinder, 0.0);
        ASSERT_GE(InPlusCylinder(order).cylinder, 0.0);
        if (order.cylinder != 0.0) {
          ASSERT_GT(*other.axis_deg, 0.0);
          ASSERT_LE(*other.axis_deg, 180.0);
        }
        ++count;
      }
    }
  }
  EXPECT_GT(count, 400000U);
}

TEST(Prescription, BothFormsAreTheSamePower) {
  for (int axis = 0; axis <= 180; axis += 7) {
    const EyePrescription order{-2.25, -1.37, static_cast<double>(axis), {}, {}, {}, {}};
    const EyePrescription other = Transposed(order);
    const auto matrix = [](const EyePrescription& eye) {
      return MatrixFrom({eye.sphere, eye.cylinder, RadiansFromDegrees(*eye.axis_deg)});
    };
    EXPECT_NEAR((matrix(order) - matrix(other)).norm(), 0.0, 1e-12) << axis;
  }
}

TEST(Prescription, ABaseAngleIsReadFromTheFront) {
  // 0° is the viewer's right: the right eye's nose, the left eye's temple.
  EXPECT_EQ(PrismFromBase(3.0, 0.0, Eye::kRight), (Prism{3.0, 0.0}));
  EXPECT_EQ(PrismFromBase(3.0, 0.0, Eye::kLeft), (Prism{-3.0, 0.0}));
  EXPECT_EQ(PrismFromBase(3.0, 90.0, Eye::kLeft).up, 3.0);
  EXPECT_EQ(PrismFromBase(3.0, 270.0, Eye::kRight).up, -3.0);
  EXPECT_EQ(PrismFromBase(2.0, 180.0, Eye::kLeft), (Prism{2.0, 0.0}));
  const Prism oblique = PrismFromBase(2.0, 30.0, Eye::kLeft);
  EXPECT_NEAR(oblique.in, -std::sqrt(3.0), 1e-6);
  EXPECT_NEAR(oblique.up, 1.0, 1e-6);
}

TEST(Prescription, AMeasurementFillsOnlyWhatIsMissingAndNeedsConfirmation) {
  Prescription rx = Usual();
  rx.centration_confirmed_by = "A. Optician";
  EXPECT_EQ(WithMeasuredPupils(rx, {30.0, 18.0}, {30.0, 18.0}), rx);
  rx.left.height.reset();
  const Prescription filled = WithMeasuredPupils(rx, {30.0, 18.0}, {30.0, 18.0});
  EXPECT_EQ(filled.right, rx.right);
  EXPECT_EQ(filled.left.pd, 32.0);
  EXPECT_EQ(filled.left.height, 18.0);
  EXPECT_FALSE(filled.centration_confirmed());
}

}  // namespace
}  // namespace annulus
