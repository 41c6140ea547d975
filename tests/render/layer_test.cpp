#include <gtest/gtest.h>

#include <array>

#include "render/scene.h"
#include "shapes.h"

namespace annulus {
namespace {

/// A head, not glasses but as hard for depths: bars before, beside and partly inside it.
Scene Head() {
  Scene scene;
  scene.items.push_back(Item(SphereMesh({0, 0, 0}, 40.0, 64), SkinMaterial()));
  scene.items.push_back(Item(SphereMesh({0, 36, -6}, 9.0, 32), SkinMaterial()));
  return scene;
}

Scene Frame(double shift) {
  Scene scene;
  scene.items.push_back(Item(SphereMesh({-15, 33 + shift, 5}, 10.0, 32), MetalMaterial(LinearFromHex(0xffd791))));
  scene.items.push_back(Item(QuadMesh({-50, 30 + shift, 3}, {100, 0, 1}, {0, 1, 4}), PlasticMaterial({0.1F, 0, 0})));
  scene.items.push_back(Item(QuadMesh({41, -30, 3}, {0, 70 + shift, 0}, {0, 0, 4}), PlasticMaterial({0, 0.1F, 0})));
  SceneItem lens = Item(QuadMesh({2, 44 + shift, -8}, {22, 1, 0}, {0, 2, 20}), ExactLens({0.6F, 0.7F, 0.8F}));
  lens.material.lens_power = -3.0F;
  scene.items.push_back(lens);
  return scene;
}

Scene Together(const Scene& head, const Scene& frame) {
  Scene scene = head;
  scene.items.insert(scene.items.end(), frame.items.begin(), frame.items.end());
  return scene;
}

TEST(Layer, AKeptHeadUnderManyFramesEqualsDrawingBothTogether) {
  const Scene head = Head();
  RenderOptions options;
  options.width = 130;
  options.height = 110;
  for (const char* view : {"front", "left45", "right45", "200,-30"}) {
    const Camera camera = FrameCamera(BoundsOf(Together(head, Frame(6.0))), ParseView(view).value(), {}).value();
    for (const int side : {1, 2, 3}) {
      options.supersampling = side;
      const Layer kept = WithAmbientLight(RenderLayer(head, camera, options, {}).value(), camera, options, {}).value();
      for (const double shift : {0.0, 6.0, -20.0}) {
        const Scene frame = Frame(shift);
        const Scene together = Together(head, frame);
        const Layer composed = Compose(kept, RenderLayer(frame, camera, options, {}).value()).value();
        const RgbImage apart = FinishImage(composed, frame, camera, options, {}).value();
        const RgbImage at_once = Render(together, camera, options, {}).value();
        EXPECT_EQ(apart.rgb, at_once.rgb) << view << " " << side << " " << shift;
        EXPECT_EQ(apart.depth, at_once.depth);
        EXPECT_EQ(apart.alpha, at_once.alpha);
      }
    }
  }
}

TEST(Layer, TheFrameShadesTheFaceThoughDrawnApart) {
  const Scene head = Head();
  const Scene frame = Frame(6.0);
  RenderOptions options;
  options.occlusion = 1.0;
  const Camera camera = FrameCamera(BoundsOf(Together(head, frame)), ParseView("front").value(), {}).value();
  const Layer kept = WithAmbientLight(RenderLayer(head, camera, options, {}).value(), camera, options, {}).value();
  const Layer composed = Compose(kept, RenderLayer(frame, camera, options, {}).value()).value();
  const RgbImage bare = FinishImage(kept, {}, camera, options, {}).value();
  const RgbImage worn = FinishImage(composed, {}, camera, options, {}).value();
  int darker = 0;
  for (std::size_t k = 0; k < bare.rgb.size(); ++k) {
    if (worn.depth[k] == bare.depth[k] && worn.rgb[k].sum() < 0.97F * bare.rgb[k].sum()) ++darker;
  }
  EXPECT_GT(darker, 200);
}

TEST(Layer, ComposingTwiceKeepsWhatIsNearer) {
  const Scene head = Head();
  const Scene first = Frame(6.0);
  const Scene second = Frame(-5.0);
  RenderOptions options = PlainOptions(90, 90);
  options.occlusion = 0.6;
  const Camera camera = FrameCamera(BoundsOf(Together(head, first)), ParseView("left45").value(), {}).value();
  const Layer kept = WithAmbientLight(RenderLayer(head, camera, options, {}).value(), camera, options, {}).value();
  const Layer twice = Compose(Compose(kept, RenderLayer(first, camera, options, {}).value()).value(),
                              RenderLayer(second, camera, options, {}).value())
                          .value();
  const Scene opaque = Together(Together(head, first), second);
  EXPECT_EQ(FinishImage(twice, {}, camera, options, {})->rgb,
            FinishImage(RenderLayer(opaque, camera, options, {}).value(), {}, camera, options, {})->rgb);
}

TEST(Layer, AlphaIsTheShareOfThePixelThatIsCovered) {
  // 1 mm pixels, 4 x 4 samples: the square covers columns from 10.25 pixels on, by halves in height.
  Scene scene;
  scene.items.push_back(Item(QuadMesh({-0.25 - 50, 0, 0.5}, {50, 0, 0}, {0, 0, 50}), SkinMaterial()));
  RenderOptions options = PlainOptions(20, 20);
  options.supersampling = 4;
  const RgbImage image = Render(scene, FrontCamera(100.0, 20), options, {}).value();
  ASSERT_EQ(image.alpha.size(), image.rgb.size());
  EXPECT_EQ(image.alpha[image.Index(9, 5)], 0.0F);
  EXPECT_EQ(image.alpha[image.Index(10, 5)], 0.75F);
  EXPECT_EQ(image.alpha[image.Index(11, 5)], 1.0F);
  EXPECT_EQ(image.alpha[image.Index(11, 9)], 0.5F);
  EXPECT_EQ(image.alpha[image.Index(11, 10)], 0.0F);
}

TEST(Layer, AlphaFollowsTheRefractedRay) {
  // A lens alone shows the backdrop and covers nothing; before a wall it covers what is seen through it.
  Scene scene;
  scene.items.push_back(Item(QuadMesh({-10, 0, -10}, {20, 0, 0}, {0, 0, 20}), ExactLens({0.5F, 0.5F, 0.5F})));
  const RgbImage alone = Render(scene, FrontCamera(100.0, 10), PlainOptions(10, 10), {}).value();
  for (const float alpha : alone.alpha) EXPECT_EQ(alpha, 0.0F);
  scene.items[0].material.lens_power = 4.0F;
  scene.items.push_back(Item(QuadMesh({-90, -15, -90}, {180, 0, 0}, {0, 0, 180}), SkinMaterial()));
  const RgbImage before_wall = Render(scene, FrontCamera(100.0, 10), PlainOptions(10, 10), {}).value();
  for (const float alpha : before_wall.alpha) EXPECT_EQ(alpha, 1.0F);
}

}  // namespace
}  // namespace annulus
