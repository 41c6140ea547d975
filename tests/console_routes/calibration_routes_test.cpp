// The guided calibration over the web, on the simulated booth, from the first step to the calibration in force.

#include <gtest/gtest.h>

#include "acquisition/calibration_file.h"
#include "station/console/calibration_run.h"
#include "station/console/calibration_steps.h"
#include "station/target_text.h"
#include "tests/console_routes/route_console.h"

namespace annulus {
namespace {

using Json = nlohmann::json;

const char* const kTargets =
    "cylinder:radius_mm=150,u_mm=0.02,serial=C-150,certificate=K-4711,height_mm=1300 + "
    "cylinder:radius_mm=70,u_mm=0.02,serial=C-70,certificate=K-4712,height_mm=1300 + "
    "verify:cylinder:radius_mm=110,u_mm=0.02,serial=C-110,certificate=K-4713,height_mm=1300";

Config ImperfectBooth() {
  Config config = SimulatedConfig();
  config.sim.ring.errors = 1.0;
  config.sim.ring.seed = 5;
  ProfileConfig coarse;  // as few levels as the ring can: 15 a second
  coarse.pitch_mm = 20.0;
  coarse.speed_mm_s = 300.0;
  config.profiles["target"] = coarse;
  config.calibration.file = test::BinaryFolder() + "/console-routes-in-force.json";
  return config;
}

/// Asks until nothing is being scanned any more.
Json WaitForStep(test::RouteConsole& console) {
  for (;;) {
    const Json run = console.Ask("GET", "/api/calibration").json["run"];
    if (run["state"] != "scanning") return run;
    std::this_thread::yield();
  }
}

TEST(CalibrationRoutes, GoFromTheFirstStepToACalibrationInForce) {
  PosixStorage storage;
  const Config config = ImperfectBooth();
  if (storage.Exists(config.calibration.file)) {
    ASSERT_TRUE(storage.Remove(config.calibration.file));
  }
  test::RouteConsole console(config);
  const auto begun = console.Ask("POST", "/api/calibration/begin", {{"target", kTargets}});
  ASSERT_EQ(begun.status, 200) << begun.json;
  EXPECT_EQ(begun.json["state"], "place");
  const std::size_t steps = begun.json["steps"].size();
  EXPECT_EQ(steps, 10U);  // six, three of the second, one to verify with
  EXPECT_EQ(begun.json["steps"][0]["state"], "now");
  EXPECT_EQ(begun.json["steps"][9]["picture"]["verify"], true);
  EXPECT_EQ(console.Ask("POST", "/api/calibration/begin", {{"target", kTargets}}).status, 409);
  EXPECT_EQ(console.Ask("POST", "/api/calibration/solve").status, 409);
  EXPECT_EQ(console.Ask("POST", "/api/calibration/take", {{"step", 1}}).status, 409);  // not due yet
  for (std::size_t step = 0; step < steps; ++step) {
    ASSERT_EQ(console.Ask("POST", "/api/calibration/take", {{"step", step}}).status, 200);
    const Json run = WaitForStep(console);
    ASSERT_EQ(run["steps"][step]["state"], "taken") << run["steps"][step] << run["error"];
  }
  const Json run = console.Ask("GET", "/api/calibration").json["run"];
  EXPECT_LT(run["predicted_common_mm"].get<double>(), run["budget_mm"].get<double>());
  const auto solved = console.Ask("POST", "/api/calibration/solve");
  ASSERT_EQ(solved.json["state"], "done") << solved.json;
  EXPECT_EQ(solved.json["result"]["passed"], true) << solved.json["result"]["limits"];
  EXPECT_EQ(solved.json["result"]["plots"]["after_mm"].size(), 180U);
  EXPECT_EQ(console.Ask("GET", "/api/calibration/report/run").response.body.substr(0, 5), "%PDF-");
  EXPECT_EQ(console.Ask("POST", "/api/calibration/accept", {{"confirm", false}}).field, "confirm");
  const auto accepted = console.Ask("POST", "/api/calibration/accept", {{"confirm", true}});
  ASSERT_EQ(accepted.status, 200) << accepted.json;
  EXPECT_EQ(accepted.json["in_force"], true);
  const auto file = ReadCalibrationFile(storage, config.calibration.file);
  ASSERT_TRUE(file) << file.error().Text();
  EXPECT_TRUE(file->passed);
  EXPECT_EQ(file->technician, "somebody");
  EXPECT_GT(file->valid_until_ns, console.clock.WallNow().count()) << "by the station's clock, not the simulated one";
  const auto after = console.Ask("GET", "/api/calibration").json;
  EXPECT_TRUE(after["run"].is_null());
  EXPECT_EQ(after["current"]["name"], accepted.json["name"]);
  ASSERT_EQ(after["history"].size(), 1U);
  EXPECT_EQ(after["history"][0]["verdict"], "pass");
  const std::string report = "/api/calibration/report/" + accepted.json["name"].get<std::string>();
  EXPECT_EQ(console.Ask("GET", report).response.body.substr(0, 5), "%PDF-");
  EXPECT_EQ(console.Ask("GET", report + "?file=data.json").json["passed"], true);
  EXPECT_EQ(console.Ask("GET", report + "?file=../CAL.json").field, "file");
  EXPECT_EQ(console.Ask("GET", "/api/calibration/report/no-such").status, 404);
}

TEST(CalibrationRoutes, RefuseWhatIsNoTargetOrNoBoard) {
  test::RouteConsole console;
  const auto field_of = [&](const Json& body) { return console.Ask("POST", "/api/calibration/begin", body).field; };
  EXPECT_EQ(field_of(Json::object()), "target");
  EXPECT_EQ(field_of({{"target", "teapot:radius_mm=3"}}), "target");
  EXPECT_EQ(field_of({{"target", "plan.toml"}}), "target");  // no files of this machine
  EXPECT_EQ(field_of({{"target", "verify:cylinder:radius_mm=150,u_mm=0.02"}}), "target");
  EXPECT_EQ(field_of({{"target", "cylinder:radius_mm=150,u_mm=0.02"}, {"board", "x"}}), "board");
  EXPECT_EQ(field_of({{"target", "cylinder:radius_mm=150,u_mm=0.02"}, {"ambient_c", 80}}), "ambient_c");
  EXPECT_EQ(console.Ask("POST", "/api/calibration/take", {{"step", 0}}).status, 409);
  EXPECT_EQ(console.Ask("POST", "/api/calibration/take").field, "step");
  EXPECT_EQ(console.Ask("POST", "/api/calibration/abandon").status, 200);
}

/// Fails as often as it is told to, then does what another does.
class FailingTaker final : public PlacementTaker {
 public:
  explicit FailingTaker(int failures) : failures_(failures) {}
  Result<TakenPlacement> Take(const CalibrationPlan&, std::size_t, const std::string&, const TaskContext&) override {
    ++calls;
    if (calls <= failures_) return Fail("scan a placement", "the door is open", "shut the door");
    return Fail("scan a placement", "there is no booth here", "end the test");
  }
  int calls = 0;

 private:
  int failures_;
};

TEST(CalibrationRun, GoesOnAfterAScanThatFailed) {
  test::RouteConsole console;
  CalibrationRun run(console.context);
  run.UseTaker(std::make_unique<FailingTaker>(1));
  CalibrationOrder order;
  order.targets = {"cylinder:radius_mm=150,u_mm=0.02"};
  order.plan.targets = {ParseTarget(order.targets[0]).value()};
  order.plan.placements = UsualPlacements(order.plan.targets, {false});
  ASSERT_TRUE(run.Begin(order));
  ASSERT_TRUE(run.Take(0));
  run.WaitForScan();
  const auto report = run.Report();
  EXPECT_EQ(report["state"], "place");
  EXPECT_EQ(report["error"]["seen"], "the door is open");
  EXPECT_EQ(report["steps"][0]["state"], "failed");
  EXPECT_TRUE(run.Take(0));
  run.Abandon();
  EXPECT_TRUE(run.Report().is_null());
  EXPECT_TRUE(run.Begin(order));  // another one can begin
}

TEST(CalibrationPlanToml, ReadsBackAsThePlan) {
  CalibrationPlan plan;
  plan.technician = "T. \"Ester\" \\";
  plan.ambient_c = 21.5;
  const std::vector<std::string> targets{"cylinder:radius_mm=150,u_mm=0.02",
                                         "step:radius_mm=100,u_mm=0.01,step_mm=10,"
                                         "edges_mm=100;300;500"};
  for (const std::string& target : targets) plan.targets.push_back(ParseTarget(target).value());
  plan.placements = UsualPlacements(plan.targets, {false, false});
  plan.placements[2].scan = "folder/placement-3.mcap";
  const auto read = ParseCalibrationPlan(CalibrationPlanToml(plan, targets), "plan.toml");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(read->technician, plan.technician);
  EXPECT_EQ(read->ambient_c, 21.5);
  EXPECT_EQ(read->targets, plan.targets);
  ASSERT_EQ(read->placements.size(), plan.placements.size());
  for (std::size_t k = 0; k < plan.placements.size(); ++k) {
    EXPECT_EQ(read->placements[k].x_mm, plan.placements[k].x_mm);
    EXPECT_EQ(read->placements[k].turn_deg, plan.placements[k].turn_deg);
    EXPECT_EQ(read->placements[k].scan, plan.placements[k].scan);
    EXPECT_EQ(read->placements[k].target, plan.placements[k].target);
  }
}

}  // namespace
}  // namespace annulus
