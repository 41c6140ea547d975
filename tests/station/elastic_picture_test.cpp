#include "station/elastic_picture.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/units.h"
#include "tests/modeling_flatten/flat_bodies.h"

namespace annulus {
namespace {

SurfaceModel Trunk() {
  SurfaceModel model;
  model.segments.push_back(test::Trunk(130.0, 20.0));
  KnowledgeMap& knowledge = model.segments[0].knowledge;
  knowledge = KnowledgeMap(60, 50, 900.0, 1400.0);
  for (std::size_t row = 0; row < 50; ++row) {
    for (std::size_t column = 0; column < 60; ++column) knowledge.SetCell(column, row, Knowledge::kMeasured);
  }
  return model;
}

/// How many pixels of a picture are clearly redder than blue, or bluer than red.
struct Tinted {
  int red = 0;
  int blue = 0;

  explicit Tinted(const RgbImage& image) {
    for (const LinearRgb& pixel : image.rgb) {
      if (pixel[0] > 1.5F * pixel[2]) ++red;
      if (pixel[2] > 1.5F * pixel[0]) ++blue;
    }
  }
};

Result<RgbImage> Picture(const SurfaceModel& model, double outward, const ElasticPictureOptions& options) {
  ElasticScript script;
  script.edits.push_back({0.5 * kPi, 1200.0, outward, 70.0});
  const auto edit = EditElastically(model, script, {});
  if (!edit) return Fail(edit);
  return DrawElasticEdit(model, *edit, options, {});
}

TEST(DrawElasticEdit, ShowsWhatMovedOutwardInRed) {
  const SurfaceModel model = Trunk();
  const auto raised = Picture(model, 10.0, {nullptr, {}, 160});
  const auto dented = Picture(model, -10.0, {nullptr, {}, 160});
  ASSERT_TRUE(raised) << raised.error().Text();
  ASSERT_TRUE(dented);
  // The legend has both colours in both pictures.
  EXPECT_GT(Tinted(*raised).red, Tinted(*dented).red + 100);
  EXPECT_GT(Tinted(*dented).blue, Tinted(*raised).blue + 100);
}

TEST(DrawElasticEdit, LooksFromWhereItIsAsked) {
  const SurfaceModel model = Trunk();
  const auto front = Picture(model, 10.0, {nullptr, View{0.5 * kPi, 0.0}, 160});
  const auto back = Picture(model, 10.0, {nullptr, View{1.5 * kPi, 0.0}, 160});
  ASSERT_TRUE(front) << front.error().Text();
  ASSERT_TRUE(back);
  EXPECT_GT(Tinted(*front).red, Tinted(*back).red + 100);
}

}  // namespace
}  // namespace annulus
