#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "base/units.h"
#include "modeling/exchange/model_json.h"
#include "sim/random_head.h"
#include "tests/console_routes/mesh_reader.h"
#include "tests/console_routes/route_console.h"
#include "tests/support/head_surface.h"

namespace annulus {
namespace {

using Json = nlohmann::json;

/// A head whose surface is known exactly, without a scan.
const SurfaceModel& Head() {
  static const SurfaceModel head = test::HeadSurface(sim::MakeRandomHead(5));
  return head;
}
double MiddleHeight() { return 0.5 * (Head().main().surface.z_min() + Head().main().surface.z_max()); }

class ReshapeRoutes : public testing::Test {
 protected:
  void SetUp() override {
    Consent consent;
    consent.purposes = {"measure", "reshape"};
    console.store.consents = {consent};
  }
  test::RouteConsole console;
  std::string scan = console.AddModel(Head());

  [[nodiscard]] std::string At(const std::string& what) const { return "/api/scans/" + scan + "/" + what; }
};

/// A finger at the back of the head, where it is smooth.
Json Push(double depth) {
  const Eigen::Vector3d back = Head().main().surface.Point(1.5 * kPi, MiddleHeight());
  return {{"operations",
           {{{"op", "push"},
             {"model", 2},
             {"near_mm", {back.x(), back.y(), back.z()}},
             {"depth_mm", depth},
             {"radius_mm", 20}}}}};
}

TEST_F(ReshapeRoutes, PreviewKeepsTheVolumeAndFollowsGirths) {
  const auto before = console.Ask("POST", At("clay/preview"),
                                  {{"script", {{"operations", Json::array()}}}, {"girths_mm", {MiddleHeight()}}});
  ASSERT_EQ(before.status, 200) << before.json;
  const auto after = console.Ask("POST", At("clay/preview"), {{"script", Push(2.0)}, {"girths_mm", {MiddleHeight()}}});
  ASSERT_EQ(after.status, 200) << after.json;
  const Json was = Json::parse(before.Header("X-Annulus-Notes"));
  const Json is = Json::parse(after.Header("X-Annulus-Notes"));
  EXPECT_NEAR(is["volume_mm3"].get<double>() / was["volume_mm3"].get<double>(), 1.0, 1e-12);
  ASSERT_EQ(is["operations"].size(), 1U);
  EXPECT_EQ(is["operations"][0]["moved_mm3"], 0.0);
  // The section goes through the dent: the tape spans it, the body has swollen.
  EXPECT_NE(is["girths"][0]["tape_mm"], was["girths"][0]["tape_mm"]);
  const test::ReadMesh mesh = test::ReadMeshBytes(after.response.body);
  EXPECT_GT(mesh.indices.size(), 1000U);
}

TEST_F(ReshapeRoutes, NothingIsReshapedWithoutConsent) {
  for (const bool withdrawn : {false, true}) {
    Consent consent;
    consent.purposes = {"measure"};
    if (withdrawn) {
      consent.purposes.emplace_back("reshape");
      consent.withdrawn = StoreTime(1);
    }
    console.store.consents = {consent};
    for (const char* route : {"clay/preview", "reshape"}) {
      const auto answer = console.Ask("POST", At(route), {{"script", Push(1.0)}});
      EXPECT_EQ(answer.status, 403) << route;
    }
  }
}

TEST_F(ReshapeRoutes, AJobLeavesAModelBesideTheScansOwn) {
  const Json elastic{{"edits", {{{"theta_deg", 90}, {"z_mm", MiddleHeight()}, {"outward_mm", 2}, {"radius_mm", 30}}}}};
  for (const auto& [tool, script] : {std::pair<std::string, Json>("elastic", elastic), {"clay", Push(1.0)}}) {
    const auto started = console.Ask("POST", At("reshape"), {{"tool", tool}, {"script", script}});
    ASSERT_EQ(started.status, 200) << started.json;
    const auto job = console.jobs.Get(started.json["id"].get<std::string>());
    ASSERT_TRUE(job);
    ASSERT_EQ(job->state, JobState::kDone) << tool << (job->error ? job->error->Text() : "");
    const Json result = Json::parse(job->result_json);
    EXPECT_EQ(result["model"]["kind"], "reshaped");
    EXPECT_TRUE(result["report"].is_object());
    const auto bytes = console.store.ReadArtefact(result["model"]["id"].get<std::string>());
    ASSERT_TRUE(bytes);
    const auto model = ModelFromJson({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, "reshaped.json");
    ASSERT_TRUE(model) << model.error().Text();
    EXPECT_NE(model->provenance.method.find("+" + tool), std::string::npos);
  }
  std::set<std::string> kinds;
  const auto artefacts = console.store.ArtefactsOf(scan);
  ASSERT_TRUE(artefacts);
  for (const Artefact& artefact : *artefacts) kinds.insert(artefact.kind);
  EXPECT_EQ(kinds, (std::set<std::string>{"model", "reshaped"}));
}

TEST_F(ReshapeRoutes, BadRequestsAreTold) {
  EXPECT_EQ(console.Ask("POST", At("clay/preview"), Json::object()).status, 400);
  EXPECT_EQ(console.Ask("POST", At("clay/preview"), {{"script", {{"operations", {{{"op", "fly"}}}}}}}).status, 400);
  EXPECT_EQ(console.Ask("POST", At("clay/preview"), {{"script", Push(1.0)}, {"girths_mm", "all"}}).status, 400);
  EXPECT_EQ(console.Ask("POST", At("reshape"), {{"script", Push(1.0)}, {"tool", "hammer"}}).status, 400);
  EXPECT_EQ(console.Ask("POST", "/api/scans/S-99/reshape", {{"script", Push(1.0)}}).status, 404);
  // As deep as the head is thick: the operation is refused, and named.
  const auto folded = console.Ask("POST", At("clay/preview"), {{"script", Push(400.0)}});
  EXPECT_EQ(folded.status, 409);
  EXPECT_NE(folded.json["attempted"].get<std::string>().find("operation 0"), std::string::npos);
}

}  // namespace
}  // namespace annulus
