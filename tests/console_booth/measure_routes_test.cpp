#include <chrono>
#include <numbers>

#include "fitting/bspline_basis.h"
#include "modeling/exchange/model_json.h"
#include "modeling/landmarks/landmark_edit.h"
#include "tests/console_booth/console_parts.h"
#include "tests/modeling_measure/interpolated_body.h"

namespace annulus {
namespace {

using nlohmann::json;
using test::Answer;
using test::ConsoleParts;
using test::FreshFolder;
using test::RouteCaller;
using testing::HasSubstr;

constexpr double kRadius = 150.0;
constexpr double kPi2 = 2.0 * std::numbers::pi;

/// A cylinder about the axis, 0 … 300 mm, in the store as the model of a scan.
class MeasureRoutes : public testing::Test {
 protected:
  MeasureRoutes() : parts_(folder_ / "nobody.sock", "/bin/false") {
    AddMeasureRoutes(routes_.table, parts_.context());
    AddScanRoutes(routes_.table, parts_.context());
    scan_ = AddScanWith([](double, double) { return kRadius; });
  }
  std::string AddScanWith(const test::RadiusFunction& radius) {
    const auto [customer, consent] = parts_.Somebody();
    const std::string file = folder_ / "scan.mcap";
    std::ofstream(file) << "a recording";
    ScanRow row;
    row.customer_id = customer;
    row.consent_id = consent;
    const ScanRow scan = *parts_.store().AddScan(row, file, nullptr);
    Artefact artefact;
    artefact.scan_id = scan.id;
    artefact.customer_id = customer;
    artefact.kind = "model";
    artefact.name = "model.json";
    const std::string model = ModelToJson(test::InterpolatedBody(radius, 72, UniformBreakpoints(0.0, 300.0, 30)));
    EXPECT_TRUE(parts_.store().PutArtefact(artefact, std::as_bytes(std::span(model))));
    return scan.id;
  }
  Answer Ask(const std::string& what, const json& body) {
    return routes_.Post("/api/scans/" + scan_ + "/" + what, body);
  }

  FreshFolder folder_;
  ConsoleParts parts_;
  RouteCaller routes_;
  std::string scan_;
};

TEST_F(MeasureRoutes, PickWhereARayMeetsTheSkin) {
  const Answer hit = Ask("pick", {{"origin", {0.0, 1000.0, 120.0}}, {"direction", {0.0, -2.0, 0.0}}});
  ASSERT_EQ(hit.status, 200) << hit.seen;
  EXPECT_EQ(hit.json.at("hit"), true);
  EXPECT_NEAR(hit.json.at("x_mm").get<double>(), 0.0, 1e-6);
  EXPECT_NEAR(hit.json.at("y_mm").get<double>(), kRadius, 1e-6);
  EXPECT_NEAR(hit.json.at("z_mm").get<double>(), 120.0, 1e-6);
  EXPECT_NEAR(hit.json.at("theta_deg").get<double>(), 90.0, 1e-6);
  EXPECT_NEAR(hit.json.at("ny").get<double>(), 1.0, 1e-6);
  EXPECT_EQ(hit.json.at("knowledge"), "measured");
  // Slanted: y falls by 1 for every mm of z; it meets y = 150 at z = 100.
  const Answer slanted = Ask("pick", {{"origin", {0.0, 200.0, 50.0}}, {"direction", {0.0, -1.0, 1.0}}});
  EXPECT_NEAR(slanted.json.at("z_mm").get<double>(), 100.0, 1e-3);
  EXPECT_EQ(Ask("pick", {{"origin", {0.0, 1000.0, 120.0}}, {"direction", {1.0, 0.0, 0.0}}}).json.at("hit"), false);
  EXPECT_EQ(Ask("pick", {{"origin", {0.0, 1000.0, 400.0}}, {"direction", {0.0, -1.0, 0.0}}}).json.at("hit"), false)
      << "over the scanned range";
}

TEST_F(MeasureRoutes, TakeTheNearestPlaceOfAPoint) {
  const Answer near = Ask("pick", {{"x_mm", 10.0}, {"y_mm", 0.0}, {"z_mm", 77.0}});
  ASSERT_EQ(near.status, 200) << near.seen;
  EXPECT_NEAR(near.json.at("x_mm").get<double>(), kRadius, 1e-6);
  EXPECT_NEAR(near.json.at("z_mm").get<double>(), 77.0, 1e-6);
  const Answer given = Ask("pick", {{"theta_deg", 180.0}, {"z_mm", 10.0}});
  EXPECT_NEAR(given.json.at("x_mm").get<double>(), -kRadius, 1e-6);
}

TEST_F(MeasureRoutes, MeasureDistancesAsOnAnUnrolledCylinder) {
  const json from{{"theta_deg", 60.0}, {"z_mm", 100.0}};
  const json to{{"theta_deg", 120.0}, {"z_mm", 180.0}};
  const double unrolled = std::hypot(kRadius * kPi2 / 6.0, 80.0);
  for (const char* method : {"geodesic", "tape"}) {
    const Answer answer = Ask("distance", {{"from", from}, {"to", to}, {"method", method}});
    ASSERT_EQ(answer.status, 200) << answer.seen;
    EXPECT_NEAR(answer.json.at("length_mm").get<double>(), unrolled, 0.01) << method;
    EXPECT_GT(answer.json.at("path").size(), 2U);
  }
  // A level plane through three places of one height cuts an arc.
  const auto at = [](double theta) { return json{{"theta_deg", theta}, {"z_mm", 150.0}}; };
  const Answer plane = Ask("distance", {{"from", at(0)}, {"via", at(45)}, {"to", at(90)}, {"method", "plane"}});
  ASSERT_EQ(plane.status, 200) << plane.seen;
  EXPECT_NEAR(plane.json.at("length_mm").get<double>(), kRadius * kPi2 / 4.0, 1e-3);
  const Answer view = Ask("distance", {{"from", at(60)},
                                       {"to", at(120)},
                                       {"view", {{"azimuth_deg", 90.0}, {"elevation_deg", 0.0}}},
                                       {"method", "view"}});
  ASSERT_EQ(view.status, 200) << view.seen;
  EXPECT_NEAR(view.json.at("length_mm").get<double>(), kRadius * kPi2 / 6.0, 1e-3);
}

TEST_F(MeasureRoutes, MeasureSectionsLevelAndTilted) {
  const Answer level = Ask("section", {{"z_mm", 150.0}});
  ASSERT_EQ(level.status, 200) << level.seen;
  EXPECT_NEAR(level.json.at("perimeter_mm").get<double>(), kRadius * kPi2, 1e-3);
  EXPECT_NEAR(level.json.at("tape_mm").get<double>(), kRadius * kPi2, 1e-2);
  EXPECT_NEAR(level.json.at("taut_tape_mm").get<double>(), kRadius * kPi2, 1e-2);
  EXPECT_NEAR(level.json.at("area_mm2").get<double>(), kRadius * kRadius * kPi2 / 2.0, 0.1);
  ASSERT_EQ(level.json.at("loops").size(), 1U);
  EXPECT_EQ(level.json.at("loops")[0].size(), 360U);
  // An ellipse of semi-axes r and r/cos 30°: area = pi r² / cos.
  const Answer tilted = Ask("section", {{"z_mm", 150.0}, {"tilt_deg", 30.0}});
  ASSERT_EQ(tilted.status, 200) << tilted.seen;
  EXPECT_NEAR(tilted.json.at("area_mm2").get<double>(), std::numbers::pi * kRadius * kRadius / std::cos(kPi2 / 12.0),
              1.0);
  EXPECT_EQ(Ask("section", {{"z_mm", 150.0}, {"tilt_deg", 80.0}}).field, "tilt_deg");
  EXPECT_EQ(Ask("section", {{"z_mm", 900.0}}).status, 400);
}

TEST_F(MeasureRoutes, MeasureSlabsAndRegions) {
  const Answer slab = Ask("slab", {{"z_min_mm", 100.0}, {"z_max_mm", 200.0}});
  ASSERT_EQ(slab.status, 200) << slab.seen;
  EXPECT_NEAR(slab.json.at("volume_mm3").get<double>(), std::numbers::pi * kRadius * kRadius * 100.0, 10.0);
  EXPECT_NEAR(slab.json.at("area_mm2").get<double>(), kPi2 * kRadius * 100.0, 1.0);
  EXPECT_EQ(Ask("slab", {{"z_min_mm", 200.0}, {"z_max_mm", 100.0}}).field, "z_max_mm");
  const auto at = [](double theta, double z) { return json{{"theta_deg", theta}, {"z_mm", z}}; };
  const Answer region = Ask("region", {{"a", at(0, 150)}, {"b", at(180, 150)}, {"c", at(90, 200)}, {"d", at(90, 100)}});
  ASSERT_EQ(region.status, 200) << region.seen;
  // Two wedges of a cylinder (hoofs) with slope h/r: volume 2/3 r² h each, area 2 r h each.
  EXPECT_NEAR(region.json.at("volume_mm3").get<double>(), 2.0 * 2.0 / 3.0 * kRadius * kRadius * 50.0, 20.0);
  EXPECT_NEAR(region.json.at("area_mm2").get<double>(), 2.0 * 2.0 * kRadius * 50.0, 1.0);
  EXPECT_GT(region.json.at("outline").size(), 4U);
}

TEST_F(MeasureRoutes, NameWhatIsWrongOfAPlace) {
  const json good{{"theta_deg", 60.0}, {"z_mm", 100.0}};
  const auto field = [&](const json& to) {
    return Ask("distance", {{"from", good}, {"to", to}, {"method", "geodesic"}}).field;
  };
  EXPECT_EQ(field(nullptr), "to");
  EXPECT_EQ(field({{"theta_deg", "front"}, {"z_mm", 1.0}}), "to");
  EXPECT_EQ(field({{"theta_deg", 60.0}}), "to");
  EXPECT_EQ(field({{"x_mm", 1e9}, {"y_mm", 0.0}, {"z_mm", 0.0}}), "to");
  EXPECT_EQ(Ask("distance", {{"from", good}, {"to", good}, {"method", "crow"}}).field, "method");
  EXPECT_EQ(Ask("distance", {{"from", good}, {"to", good}, {"method", "plane"}}).field, "via");
  EXPECT_EQ(Ask("distance", {{"from", good}, {"to", good}, {"method", "view"}}).field, "view");
  EXPECT_EQ(Ask("pick", {{"origin", {0, 0}}, {"direction", {0, 1, 0}}}).field, "origin");
  EXPECT_EQ(Ask("pick", {{"origin", {0, 0, 0}}, {"direction", {0, 0, 0}}}).field, "direction");
  EXPECT_EQ(routes_.Post("/api/scans/S-9/section", {{"z_mm", 1.0}}).status, 404);
}

TEST_F(MeasureRoutes, DrawTheBodyOnlyOnceItIsReleased) {
  const std::string mesh = "/api/scans/" + scan_ + "/mesh";
  EXPECT_EQ(routes_.Get(mesh).status, 403);
  ASSERT_EQ(routes_.Post("/api/scans/" + scan_ + "/release").status, 200);
  const Answer drawn = routes_.Get(mesh);
  ASSERT_EQ(drawn.status, 200) << drawn.seen;
  const auto word = [&](std::size_t k) {
    std::uint32_t value = 0;
    std::memcpy(&value, drawn.body.data() + 4 * k, 4);
    return value;
  };
  EXPECT_EQ(word(0), 0x4d534e41U);
  EXPECT_EQ(word(1), 1U);
  EXPECT_GT(word(3), 10'000U);
  EXPECT_LE(word(3), 40'000U);
  float x = 0.0F;
  float y = 0.0F;
  std::memcpy(&x, drawn.body.data() + 16, 4);
  std::memcpy(&y, drawn.body.data() + 20, 4);
  EXPECT_NEAR(std::hypot(x, y), kRadius, 0.01);
  const Answer coarse = routes_.Get(mesh + "?step_deg=10&step_mm=20");
  EXPECT_LT(coarse.body.size(), drawn.body.size());
  EXPECT_EQ(routes_.Get(mesh + "?step_mm=0").field, "step_mm");
  const Answer few = routes_.Get(mesh + "?triangles=5000");
  std::uint32_t triangles = 0;
  std::memcpy(&triangles, few.body.data() + 12, 4);
  EXPECT_LE(triangles, 5'000U);
  EXPECT_GT(triangles, 2'500U);
  EXPECT_EQ(routes_.Get(mesh + "?triangles=999").field, "triangles");
}

TEST_F(MeasureRoutes, GiveTheMeshOfTheBodyAsAFile) {
  const Answer stl = routes_.Get("/api/scans/" + scan_ + "/document?kind=stl");
  ASSERT_EQ(stl.status, 200) << stl.seen;
  EXPECT_GT(stl.body.size(), 10'000U);
  EXPECT_EQ(routes_.Get("/api/scans/" + scan_ + "/document?kind=cake").field, "kind");
  EXPECT_EQ(routes_.Get("/api/scans/" + scan_ + "/document?kind=recording").status, 403);
  routes_.caller.role = StationRole::kTechnician;
  EXPECT_EQ(routes_.Get("/api/scans/" + scan_ + "/document?kind=recording").body, "a recording");
  EXPECT_EQ(routes_.Get("/api/scans/" + scan_ + "/document?kind=stl").status, 403);
  const Answer scan = routes_.Get("/api/scans/" + scan_);
  EXPECT_FALSE(scan.json.contains("customer_id"));
  EXPECT_TRUE(scan.json.at("model").get<bool>());
}

TEST_F(MeasureRoutes, OpenAModelOnceAndAgainAfterAVisit) {
  int opened = 0;
  const auto cache = ModelCache::Make([&](const std::string& scan) {
    ++opened;
    return OpenStoredModel(parts_.store(), scan);
  });
  ASSERT_TRUE(cache->Open(scan_));
  ASSERT_TRUE(cache->Open(scan_));
  EXPECT_EQ(opened, 1);
  cache->DropAll();
  const auto held = cache->Open(scan_);
  EXPECT_EQ(opened, 2);
  std::vector<std::string> others;
  for (int k = 0; k < 4; ++k) others.push_back(AddScanWith([](double, double) { return 100.0; }));
  for (const std::string& other : others) ASSERT_TRUE(cache->Open(other));
  EXPECT_EQ(opened, 6);
  ASSERT_TRUE(cache->Open(scan_));
  EXPECT_EQ(opened, 7) << "four are kept";
  EXPECT_FALSE(cache->Open("S-9"));
}

TEST_F(MeasureRoutes, MoveALandmarkOnTheSurfaceThatIsOpen) {
  const auto before = *parts_.models().Open(scan_);
  const Answer moved = Ask("landmarks", {{"set", {{{"id", "level.waist"}, {"z_mm", 140.0}}}}});
  ASSERT_EQ(moved.status, 200) << moved.seen;
  const auto after = *parts_.models().Open(scan_);
  EXPECT_EQ(after->loaded.model, before->loaded.model) << "the surface is not read again";
  ASSERT_NE(after->landmarks.Find("level.waist"), nullptr);
  EXPECT_EQ(after->landmarks.Find("level.waist")->z.value, 140.0);
  EXPECT_EQ(after->landmarks.Find("level.waist")->source, LandmarkSource::kGiven);
  const auto girth = [&] {
    const json table = routes_.Get("/api/scans/" + scan_ + "/measurements").json;
    for (const json& line : table.at("measurements")) {
      if (line.at("id") == "waist_girth") return line.at("value_mm").get<double>();
    }
    return std::nan("");
  };
  EXPECT_NEAR(girth(), kPi2 * kRadius, 0.05) << "the table is measured again";
  parts_.models().DropAll();
  const auto stored = *parts_.models().Open(scan_);
  EXPECT_NE(stored->loaded.model, before->loaded.model);
  EXPECT_EQ(stored->landmarks.Find("level.waist")->z.value, 140.0) << "and it is in the store";
  ASSERT_EQ(Ask("landmarks/reset", json::object()).status, 200);
  const auto reset = *parts_.models().Open(scan_);
  EXPECT_EQ(reset->loaded.model, stored->loaded.model);
  const Landmark* waist = reset->landmarks.Find("level.waist");
  EXPECT_TRUE(waist == nullptr || waist->source != LandmarkSource::kGiven);
}

TEST_F(MeasureRoutes, MakeNoFreeSewingFileOfAHeadAlone) {
  const std::string document = "/api/scans/" + scan_ + "/document?kind=freesewing";
  ASSERT_EQ(Ask("landmarks", {{"set", {{{"id", "level.head"}, {"z_mm", 220.0}}}}}).status, 200);
  const Answer head = routes_.Get(document);
  EXPECT_EQ(head.status, 409);
  EXPECT_THAT(head.seen, HasSubstr("none of chest, waist or hip"));
  ASSERT_EQ(Ask("landmarks", {{"set", {{{"id", "level.waist"}, {"z_mm", 140.0}}}}}).status, 200);
  const Answer body = routes_.Get(document);
  ASSERT_EQ(body.status, 200) << body.seen;
  EXPECT_NEAR(body.json.at("waist").get<double>(), kPi2 * kRadius, 0.05);
}

TEST_F(MeasureRoutes, KeepTheStoresLandmarksWhenTwoMoveThemAtOnce) {
  const auto before = *parts_.models().Open(scan_);
  const auto with = [&](double z) {
    const auto changed = std::make_shared<OpenModel>(*before);
    changed->landmarks = *SetByHand(before->loaded.body, before->landmarks, {"level.waist", std::nullopt, z});
    return changed;
  };
  const auto first = with(140.0);
  parts_.models().Change(*before, first);
  EXPECT_EQ(*parts_.models().Open(scan_), first);
  parts_.models().Change(*before, with(150.0));  // made from what was there before the first
  EXPECT_EQ((*parts_.models().Open(scan_))->landmarks.Find("level.waist"), nullptr) << "as the store has it";
}

}  // namespace
}  // namespace annulus
