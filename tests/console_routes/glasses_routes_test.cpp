#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <set>

#include "modeling/glasses/frame_fields.h"
#include "modeling/glasses/frame_library.h"
#include "sim/random_head.h"
#include "tests/console_routes/mesh_reader.h"
#include "tests/console_routes/route_console.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

using Json = nlohmann::json;

/// One head for all tests: its surface is known exactly, without a scan.
const sim::ParametricBody& Head() {
  static const sim::ParametricBody head = sim::MakeRandomHead(5);
  return head;
}
const SurfaceModel& HeadModel() {
  static const SurfaceModel model = test::HeadSurface(Head());
  return model;
}

class GlassesRoutes : public testing::Test {
 protected:
  test::RouteConsole console;
  std::string scan = console.AddModel(HeadModel());

  [[nodiscard]] std::string At(const std::string& what) const { return "/api/scans/" + scan + "/" + what; }
  test::RouteAnswer Preview(const Json& body) { return console.Ask("POST", At("glasses/preview"), body); }
};

Json Design(const std::string& style, const std::string& size = "", const Json& fields = Json::object()) {
  return {{"style", style}, {"size", size}, {"fields", fields}};
}

TEST_F(GlassesRoutes, CatalogueIsTheLibraryAndThePapersEightSliders) {
  const auto answer = console.Ask("GET", "/api/glasses/catalogue");
  ASSERT_EQ(answer.status, 200);
  const FrameLibrary& library = BuiltInFrameLibrary();
  ASSERT_EQ(answer.json["styles"].size(), library.styles.size());
  for (std::size_t k = 0; k < library.styles.size(); ++k) {
    const Json& style = answer.json["styles"][k];
    EXPECT_EQ(style["id"], library.styles[k].name);
    EXPECT_EQ(style["sizes"].size(), library.styles[k].sizes.size());
    EXPECT_EQ(style["values"]["height"], library.styles[k].design.parameters.height);
  }
  // Paper 000, fig. 22: [1] … [4] corners, [1,2] and [3,4] thickness, [5] height, [6] height of the bridge.
  std::vector<std::string> sliders;
  for (const Json& slider : answer.json["sliders"]) sliders.push_back(slider["id"]);
  EXPECT_EQ(std::set<std::string>(sliders.begin(), sliders.end()),
            (std::set<std::string>{"upper-outer", "upper-inner", "lower-outer", "lower-inner", "upper-thickness",
                                   "lower-thickness", "height", "bridge-height"}));
  EXPECT_EQ(sliders.size(), 8U);
  EXPECT_EQ(answer.json["colours"].size(), 8U);   // §6.1: eight sample colours
  EXPECT_EQ(answer.json["textures"].size(), 5U);  // §6.1: five textures, one plain
}

TEST_F(GlassesRoutes, PreviewSitsOnTheFaceWithinItsTriangles) {
  const auto answer = Preview({{"design", Design("wellington", "medium")}, {"placement", "quick"}});
  ASSERT_EQ(answer.status, 200) << answer.json;
  const test::ReadMesh mesh = test::ReadMeshBytes(answer.response.body);
  EXPECT_LE(mesh.indices.size() / 3, 20'000U);
  EXPECT_GT(mesh.indices.size() / 3, 5'000U);
  ASSERT_EQ(mesh.parts.size(), 4U);
  EXPECT_EQ(mesh.parts[0].kind, 1U);
  EXPECT_EQ(mesh.parts[2].kind, 2U);
  // Each lens is before the eye that the simulated head has on that side, at its height, as far from the middle of the
  // face as the boxing system says of this size.
  const SoldSize& size = *BuiltInFrameLibrary().Find("wellington").value()->Size("medium");
  const double middle_of_eyes = 0.5 * (Head().face().right_eye.x() + Head().face().left_eye.x());
  for (std::size_t side = 0; side < 2; ++side) {
    const auto& part = mesh.parts[2 + side];
    Eigen::AlignedBox3d box;
    for (std::uint32_t k = 0; k < part.count; ++k) {
      const std::size_t vertex = mesh.indices[part.first_index + k];
      box.extend(
          Eigen::Vector3d(mesh.positions[3 * vertex], mesh.positions[3 * vertex + 1], mesh.positions[3 * vertex + 2]));
    }
    const Eigen::Vector3d middle = box.center();
    const Eigen::Vector3d eye = side == 0 ? Head().face().right_eye : Head().face().left_eye;
    EXPECT_NEAR(std::abs(middle.x() - middle_of_eyes), 0.5 * (size.a + size.dbl), 3.0);
    EXPECT_EQ(middle.x() > 0.0, eye.x() > 0.0);
    EXPECT_NEAR(middle.z(), eye.z(), 8.0);
    EXPECT_GT(middle.y() - eye.y(), 5.0);
    EXPECT_LT(middle.y() - eye.y(), 30.0);
  }
  const Json notes = Json::parse(answer.Header("X-Annulus-Notes"));
  EXPECT_EQ(notes["placement"], "fit");
  EXPECT_TRUE(notes["adjusted"].empty());
}

/// The mean of all vertices, mm.
Eigen::Vector3d MeanOf(const test::ReadMesh& mesh) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < mesh.positions.size(); k += 3) {
    sum += Eigen::Vector3d(mesh.positions[k], mesh.positions[k + 1], mesh.positions[k + 2]);
  }
  return sum * 3.0 / static_cast<double>(mesh.positions.size());
}

TEST_F(GlassesRoutes, ASliderMovesTheFrameToWhereItsOwnFitPutsIt) {
  for (const double height : {38.0, 38.4, 38.8, 39.2}) {
    const auto moved = Preview({{"design", Design("boston", "", {{"height", height}})}});
    ASSERT_EQ(moved.status, 200) << moved.json;
    test::RouteConsole fresh;
    fresh.AddModel(HeadModel());
    const auto alone =
        fresh.Ask("POST", At("glasses/preview"), {{"design", Design("boston", "", {{"height", height}})}});
    const Eigen::Vector3d difference =
        MeanOf(test::ReadMeshBytes(moved.response.body)) - MeanOf(test::ReadMeshBytes(alone.response.body));
    EXPECT_LT(difference.norm(), 1.0) << "height " << height;
  }
}

TEST_F(GlassesRoutes, EveryStyleIsShownWithinItsTriangles) {
  for (const LibraryStyle& style : BuiltInFrameLibrary().styles) {
    const auto answer = Preview({{"design", Design(style.name)}});
    ASSERT_EQ(answer.status, 200) << style.name << answer.json;
    const test::ReadMesh mesh = test::ReadMeshBytes(answer.response.body);
    EXPECT_LE(mesh.indices.size() / 3, 20'000U) << style.name;
  }
}

TEST_F(GlassesRoutes, PreviewSaysWhatItAdjusted) {
  // A bridge beside the rim's upper end cannot be: paper 000 lets it start beside the straight sides only.
  const auto answer = Preview({{"design", Design("example4", "", {{"bridge-height", 45.0}})}});
  ASSERT_EQ(answer.status, 200) << answer.json;
  const Json notes = Json::parse(answer.Header("X-Annulus-Notes"));
  ASSERT_EQ(notes["adjusted"].size(), 1U);
  EXPECT_NE(notes["adjusted"][0].get<std::string>().find("bridge-height"), std::string::npos);
  EXPECT_LT(notes["values"]["bridge-height"].get<double>(), 45.0);
}

TEST_F(GlassesRoutes, ThePapersPlacementScalesTheFrameToTheEyes) {
  const auto answer = Preview({{"design", Design("example2")}, {"placement", "paper"}});
  ASSERT_EQ(answer.status, 200) << answer.json;
  const Json notes = Json::parse(answer.Header("X-Annulus-Notes"));
  EXPECT_EQ(notes["placement"], "paper");
  // Step 1: l1 = PD / 1.2, with the PD that the head was made with.
  const double pd = (Head().face().right_eye - Head().face().left_eye).norm();
  EXPECT_NEAR(notes["values"]["width"].get<double>(), pd / 1.2, 1.5);
}

TEST_F(GlassesRoutes, ColoursOfTheLookAreThoseOfTheParts) {
  const Json look = {{"upper", {{"colour", "linear:0.25,0.5,0.75"}, {"material", "metal"}}},
                     {"lower", {{"colour", "linear:0.5,0.125,0"}}},
                     {"lens", {{"tint", "linear:0,0.25,1"}, {"transmittance", 0.25}}}};
  const auto answer = Preview({{"design", Design("round", "small")}, {"look", look}});
  ASSERT_EQ(answer.status, 200) << answer.json;
  const test::ReadMesh mesh = test::ReadMeshBytes(answer.response.body);
  EXPECT_EQ(mesh.parts[0].colour[1], 0.5F);
  EXPECT_EQ(mesh.parts[1].colour[0], 0.5F);
  EXPECT_EQ(mesh.parts[1].colour[1], 0.125F);
  EXPECT_EQ(mesh.parts[2].colour[2], 1.0F);
  EXPECT_NEAR(mesh.parts[2].colour[3], 0.75F, 1e-6F);
}

TEST_F(GlassesRoutes, TexturesLieInTheFramesOwnCoordinates) {
  const Json look = {{"upper", {{"texture", {{"pattern", "horn"}, {"scale", 2.5}, {"seed", 9}}}}},
                     {"lower", {{"texture", {{"pattern", "pearl"}, {"second", "linear:0.25,0.5,0.75"}}}}}};
  const auto answer = Preview({{"design", Design("wellington", "medium")}, {"look", look}});
  ASSERT_EQ(answer.status, 200) << answer.json;
  const Json textures = Json::parse(answer.Header("X-Annulus-Notes")).at("textures");
  EXPECT_EQ(textures["upper"]["pattern"], "horn");
  EXPECT_EQ(textures["upper"]["scale"], 2.5);
  EXPECT_EQ(textures["upper"]["seed"], 9);
  EXPECT_EQ(textures["lower"]["pattern"], "pearl");
  EXPECT_EQ(textures["lower"]["second"], Json({0.25, 0.5, 0.75}));
  // The halves are parted at the frame's middle height, where its own z is 0: upper faces above, lower ones below; and
  // its front is at y = 0, so that the temples go backwards.
  const test::ReadMesh mesh = test::ReadMeshBytes(answer.response.body);
  const auto rows = textures["frame_from_station"].get<std::vector<double>>();
  ASSERT_EQ(rows.size(), 12U);
  const auto in_frame = [&](std::size_t index, std::size_t axis) {
    const float* const p = &mesh.positions[3 * mesh.indices[index]];
    const double* const row = &rows[4 * axis];
    return row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
  };
  for (std::size_t half = 0; half < 2; ++half) {
    const auto& part = mesh.parts[half];
    for (std::size_t k = part.first_index; k < part.first_index + part.count; k += 3) {
      const double middle = (in_frame(k, 2) + in_frame(k + 1, 2) + in_frame(k + 2, 2)) / 3.0;
      ASSERT_TRUE(half == 0 ? middle > -1e-3 : middle < 1e-3) << "half " << half << ", z " << middle;
      ASSERT_LT(in_frame(k, 1), 30.0);
    }
  }
}

TEST_F(GlassesRoutes, EveryNumberOutOfItsRangeIsNamed) {
  for (const FrameField& field : FrameFields()) {
    if (field.unit == FieldUnit::kWord) continue;
    const std::string name(field.option);
    for (const double value : {field.low - 0.5, field.high + 0.5}) {
      const auto answer = Preview({{"design", Design("wellington", "", {{name, value}})}});
      EXPECT_EQ(answer.status, 400) << name << " " << value;
      EXPECT_EQ(answer.field, "design.fields." + name);
    }
  }
}

TEST_F(GlassesRoutes, WhatCannotBeUnderstoodIsNamed) {
  const std::vector<std::pair<Json, std::string>> wrong{
      {{{"look", Json::object()}}, "design"},
      {{{"design", "wellington"}}, "design"},
      {{{"design", {{"size", "medium"}}}}, "design.style"},
      {{{"design", Design("no such style")}}, "design.style"},
      {{{"design", Design("wellington", "enormous")}}, "design.size"},
      {{{"design", {{"style", "wellington"}, {"colour", "red"}}}}, "design.colour"},
      {{{"design", Design("wellington", "", {{"hight", 40}})}}, "design.fields.hight"},
      {{{"design", Design("wellington", "", {{"bridge", "drawbridge"}})}}, "design.fields.bridge"},
      {{{"design", Design("wellington", "", {{"bridge", 3}})}}, "design.fields.bridge"},
      {{{"design", Design("wellington", "", {{"height", nullptr}})}}, "design.fields.height"},
      {{{"design", Design("wellington")}, {"placement", "upside down"}}, "placement"},
      {{{"design", Design("wellington")}, {"free_size", 1}}, "free_size"},
      {{{"design", Design("wellington")}, {"desgin", 1}}, "desgin"},
      {{{"design", Design("wellington")}, {"look", 7}}, "look"},
      {{{"design", Design("wellington")}, {"look", {{"lens", {{"transmittance", 1.5}}}}}}, "look.lens.transmittance"},
      {{{"design", Design("wellington")}, {"look", {{"lens", {{"power_d", 31}}}}}}, "look.lens.power_d"},
      {{{"design", Design("wellington")}, {"look", {{"upper", {{"colour", "mauve"}}}}}}, "look.upper.colour"}};
  for (const auto& [body, field] : wrong) {
    const auto answer = Preview(body);
    EXPECT_EQ(answer.status, 400) << body;
    EXPECT_EQ(answer.field, field) << body << answer.json;
  }
  EXPECT_EQ(console.Ask("POST", "/api/scans/S-99/glasses/preview", {{"design", Design("round")}}).status, 404);
}

TEST_F(GlassesRoutes, AFitGivesGlassesThatAnExportTakes) {
  const auto fitted = console.Ask("POST", At("glasses/fit"), {{"design", Design("wellington", "medium")}});
  ASSERT_EQ(fitted.status, 200) << fitted.json;
  ASSERT_EQ(fitted.json["state"], "done") << fitted.json;
  const Json& result = fitted.json["result"];
  EXPECT_TRUE(result["report"]["wearable"].is_boolean());
  EXPECT_FALSE(result["report"]["goals"].empty());
  const std::string worn = result["worn"]["id"];
  for (const char* format : {"stl", "pdf", "json"}) {
    const auto made = console.Ask("POST", At("glasses/export"), {{"worn", worn}, {"format", format}});
    ASSERT_EQ(made.json["state"], "done") << made.json;
    const std::string id = made.json["result"]["document"]["id"];
    EXPECT_GT(console.store.ReadArtefact(id).value().size(), 100U);
  }
  const auto unconfirmed = console.Ask("POST", At("glasses/export"), {{"worn", worn}, {"format", "dcs"}});
  EXPECT_EQ(unconfirmed.status, 400);
  EXPECT_EQ(unconfirmed.field, "confirmed_by");
  EXPECT_EQ(console.Ask("POST", At("glasses/export"), {{"worn", worn}, {"format", "exe"}}).field, "format");
  EXPECT_EQ(console.Ask("POST", At("glasses/export"), {{"worn", "A-999"}, {"format", "stl"}}).field, "worn");
}

TEST_F(GlassesRoutes, AJobThatFailsSaysWhy) {
  ASSERT_TRUE(console.store.RemoveArtefact(console.models.models[scan]->artefact_id));
  const std::string text = "{}";
  Artefact damaged;
  damaged.scan_id = scan;
  damaged.kind = "model";
  damaged.name = "model.json";
  ASSERT_TRUE(console.store.PutArtefact(damaged, std::as_bytes(std::span(text))));
  const auto answer = console.Ask("POST", At("glasses/fit"), {{"design", Design("wellington", "medium")}});
  ASSERT_EQ(answer.status, 200);
  EXPECT_EQ(answer.json["state"], "failed");
  EXPECT_NE(answer.json["error"]["seen"].get<std::string>().find("model"), std::string::npos) << answer.json;
}

TEST_F(GlassesRoutes, WithoutAModelNothingIsFitted) {
  const std::string other = console.store.AddRecorded("head", {});
  const auto answer =
      console.Ask("POST", "/api/scans/" + other + "/glasses/fit", {{"design", Design("wellington", "medium")}});
  EXPECT_EQ(answer.status, 409);
  EXPECT_EQ(console.Ask("POST", "/api/scans/S-99/glasses/rank").status, 404);
}

TEST_F(GlassesRoutes, ARankingSaysWhyAndGivesDesigns) {
  const auto answer = console.Ask("POST", At("glasses/rank"), {{"top", 3}});
  ASSERT_EQ(answer.json["state"], "done") << answer.json;
  const Json& frames = answer.json["result"]["frames"];
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[0]["rank"], 1);
  EXPECT_GE(frames[0]["score"].get<double>(), frames[2]["score"].get<double>());
  EXPECT_FALSE(frames[0]["why"].get<std::string>().empty());
  EXPECT_EQ(Preview({{"design", frames[0]["design"]}}).status, 200);
  EXPECT_EQ(console.Ask("POST", At("glasses/rank"), {{"top", 0}}).field, "top");
  EXPECT_EQ(console.Ask("POST", At("glasses/rank"), {{"top", 2.5}}).field, "top");
}

TEST_F(GlassesRoutes, APictureIsKeptAndCanBeLookedAt) {
  const Json body = {{"design", Design("round", "medium")}, {"view", "left45"}, {"size", 64}, {"method", "zbuffer"}};
  EXPECT_EQ(console.Ask("POST", At("glasses/picture"), body).status, 403);  // the customer has not released it
  ASSERT_TRUE(console.store.JudgeScan(scan, "good", R"({"released": true})"));
  const auto answer = console.Ask("POST", At("glasses/picture"), body);
  ASSERT_EQ(answer.json["state"], "done") << answer.json;
  const auto picture = console.Ask("GET", "/api/jobs/" + answer.json["id"].get<std::string>() + "/picture");
  ASSERT_EQ(picture.status, 200) << picture.json;
  EXPECT_EQ(picture.response.content_type, "image/png");
  EXPECT_EQ(picture.response.body.substr(1, 3), "PNG");
  EXPECT_EQ(picture.Header("X-Annulus-Share"), "1.000");
  EXPECT_EQ(console.Ask("GET", "/api/jobs/J-99/picture").status, 404);
  for (const auto& [key, value] : std::vector<std::pair<std::string, Json>>{
           {"view", "behind"}, {"size", 63}, {"size", 2049}, {"method", "sketch"}, {"samples", 0}, {"light", "moon"}}) {
    Json wrong = body;
    wrong[key] = value;
    EXPECT_EQ(console.Ask("POST", At("glasses/picture"), wrong).field, key);
  }
}

TEST_F(GlassesRoutes, DesignsAreKeptChangedAndRemoved) {
  const auto added = console.Ask("POST", At("designs"), {{"title", "first"}, {"design", Design("round", "small")}});
  ASSERT_EQ(added.status, 200) << added.json;
  EXPECT_EQ(added.json["look"]["format"], "annulus-look");
  const auto twice = console.Ask("POST", At("designs"), {{"title", "first"}, {"design", Design("oval")}});
  EXPECT_EQ(twice.status, 409);
  const std::string id = added.json["id"];
  const auto changed = console.Ask("POST", "/api/designs/" + id, {{"title", "second"}, {"design", Design("oval")}});
  ASSERT_EQ(changed.status, 200) << changed.json;
  auto listed = console.Ask("GET", At("designs"));
  ASSERT_EQ(listed.json["designs"].size(), 1U);
  EXPECT_EQ(listed.json["designs"][0]["title"], "second");
  EXPECT_EQ(listed.json["designs"][0]["design"]["style"], "oval");
  const std::string new_id = changed.json["id"];
  EXPECT_EQ(console.Ask("POST", "/api/designs/" + new_id + "/remove").status, 200);
  EXPECT_TRUE(console.Ask("GET", At("designs")).json["designs"].empty());
  EXPECT_EQ(console.Ask("POST", "/api/designs/" + new_id, {{"title", "third"}}).status, 404);
  EXPECT_EQ(console.Ask("POST", At("designs"), {{"title", ""}, {"design", Design("round")}}).field, "title");
  EXPECT_EQ(console.Ask("POST", At("designs"), {{"title", "x"}}).field, "design");
}

TEST_F(GlassesRoutes, ColoursFollowMiyaharaAndYoshida) {
  // sRGB grey of L* 50, by CIE: value is 5 in this transform (v(Y) = 11.6 Y^(1/3) − 1.6 = L*/10).
  const auto grey = console.Ask("POST", "/api/colour", {{"rgb", {119, 119, 119}}});
  ASSERT_EQ(grey.status, 200) << grey.json;
  EXPECT_NEAR(grey.json["hvc"]["value"].get<double>(), 5.0, 0.05);
  EXPECT_NEAR(grey.json["hvc"]["chroma"].get<double>(), 0.0, 0.01);
  const auto white = console.Ask("POST", "/api/colour", {{"rgb", {10, 120, 200}}, {"change", {{"value", 1}}}});
  EXPECT_EQ(white.json["rgb"], Json({255, 255, 255}));
  EXPECT_EQ(white.json["clipped"], true);
  const auto dull = console.Ask("POST", "/api/colour", {{"rgb", {10, 120, 200}}, {"change", {{"chroma", -1}}}});
  EXPECT_EQ(dull.json["rgb"][0], dull.json["rgb"][2]);
  for (const auto& [body, field] :
       std::vector<std::pair<Json, std::string>>{{{{"rgb", {1, 2}}}, "rgb"},
                                                 {{{"rgb", {1, 2, 256}}}, "rgb"},
                                                 {{{"rgb", {1, 2, 0.5}}}, "rgb"},
                                                 {Json::object(), "rgb"},
                                                 {{{"rgb", {1, 2, 3}}, {"change", {{"value", 1.5}}}}, "change.value"},
                                                 {{{"rgb", {1, 2, 3}}, {"change", {{"chroma", -2}}}}, "change.chroma"},
                                                 {{{"hvc", {{"hue", 101}, {"value", 5}, {"chroma", 1}}}}, "hvc.hue"}}) {
    const auto answer = console.Ask("POST", "/api/colour", body);
    EXPECT_EQ(answer.status, 400) << body;
    EXPECT_EQ(answer.field, field) << body;
  }
}

}  // namespace
}  // namespace annulus
