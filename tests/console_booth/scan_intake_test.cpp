#include "station/console/scan_intake.h"

#include <sys/stat.h>

#include <fstream>

#include "acquisition/recording.h"
#include "acquisition/scan_gate.h"
#include "fitting/bspline_basis.h"
#include "modeling/exchange/model_json.h"
#include "sim/head.h"
#include "station/booth_session.h"
#include "station/console/scan_tickets.h"
#include "station/console/technician_drift.h"
#include "station/scanner_port.h"
#include "tests/console_booth/console_parts.h"
#include "tests/modeling_measure/interpolated_body.h"
#include "tests/sim/simulated_scan.h"

namespace annulus {
namespace {

using nlohmann::json;
using test::Answer;
using test::ConsoleParts;
using test::FreshFolder;
using test::RecordingHub;
using test::RouteCaller;
using testing::HasSubstr;

/// What stands for our program: a fit gives the model that lies in the file `beside` it.
std::string FitProgram(const FreshFolder& folder) {
  const std::string model = folder / "ready.json";
  std::ofstream(model) << ModelToJson(
      test::InterpolatedBody([](double, double) { return 150.0; }, 72, UniformBreakpoints(1000.0, 1300.0, 30)));
  const std::string program = folder / "program";
  std::ofstream(program) << "#!/bin/sh\n[ \"$3\" = drift ] && { shift 2; . " << (folder / "drift")
                         << "; exit; }\n[ -s scan.mcap ] || exit 1\ncp " << model
                         << " model.json\necho '{}' > report.json\n";
  std::ofstream(folder / "drift") << "echo nothing > history.json\necho '{}'\n";
  ::chmod(program.c_str(), 0700);
  return program;
}

/// A recording of a few levels as boothd leaves it.
Scan SmallScan(const std::string& customer, const std::string& consent) {
  ScanPlan plan = *BuiltInPlan("head", Millimetres(1700.0));
  plan.z_bottom_mm = plan.z_top_mm - 60.0;
  plan.pitch_mm = 5.0;
  plan.speed_mm_s = 150.0;
  plan.level_rate_hz = 30.0;
  plan.sweeps = 1;
  const sim::ParametricBody head = sim::MakeHead({});
  Scan scan = sim::SimulateScan(head, plan, {}, 7);
  scan.header.subject_id = customer;
  scan.header.consent_reference = consent;
  scan.header.wall_start_ns = SystemClock().WallNow().count();
  return scan;
}

class ScanIntakeTest : public testing::Test {
 protected:
  ScanIntakeTest() : parts_(folder_ / "nobody.sock", FitProgram(folder_)), tickets_(parts_.store()) {
    std::filesystem::create_directories(recordings_);
    std::tie(customer_, consent_) = parts_.Somebody();
  }
  ~ScanIntakeTest() override { intake_.reset(); }
  void StartIntake() { intake_ = ScanIntake::Make(parts_.context(), {recordings_, nullptr}); }
  /// The path of a recording that boothd has left, for a ticket.
  std::string Leave() {
    const auto ticket = tickets_.Add({"", customer_, consent_, "head", "anna", {}});
    EXPECT_TRUE(ticket);
    const std::string path = recordings_ + "/" + ticket->recording();
    EXPECT_TRUE(WriteRecording(parts_.storage, path, SmallScan(customer_, consent_)));
    return path;
  }
  json WaitResult() {
    const auto operators = parts_.hub.WaitFor(
        [](const RecordingHub::Sent& one) { return one.message.at("type") == "scan_result" && one.roles.operator_; });
    return json(operators);
  }
  void WaitForState(const std::string& job, JobState state) {
    const auto begin = SystemClock().Now();
    const auto reached = [&] { return parts_.jobs().Get(job) && parts_.jobs().Get(job)->state == state; };
    while (!reached() && SystemClock().Now() - begin < test::kSoon) std::this_thread::yield();
    ASSERT_TRUE(reached());
  }
  std::size_t Scans() { return parts_.store().ScansOf(customer_)->size(); }

  FreshFolder folder_;
  const std::string recordings_ = folder_ / "recordings";
  ConsoleParts parts_;
  ScanTickets tickets_;
  std::string customer_;
  std::string consent_;
  std::unique_ptr<ScanIntake> intake_;
};

TEST_F(ScanIntakeTest, TakesInWhatWasRecordedWhileTheConsoleWasAway) {
  const std::string file = Leave();
  StartIntake();
  const json told = WaitResult();
  ASSERT_FALSE(told.is_null());
  EXPECT_TRUE(told.at("error").is_null()) << told.dump();
  EXPECT_EQ(told.at("customer_id"), customer_);
  const json& scan = told.at("scan");
  EXPECT_EQ(scan.at("customer_id"), customer_);
  EXPECT_EQ(scan.at("consent_id"), consent_);
  EXPECT_GT(scan.at("summary").at("levels"), 5);
  EXPECT_EQ(scan.at("summary").at("released"), false);
  EXPECT_THAT((std::vector<std::string>{"good", "usable", "repeat"}), testing::Contains(scan.at("verdict")));
  EXPECT_FALSE(std::filesystem::exists(file));
  // What technicians hear names nobody.
  const auto technicians = parts_.hub.WaitFor(
      [](const RecordingHub::Sent& one) { return one.message.at("type") == "scan_result" && one.roles.technician; });
  EXPECT_THAT(technicians.dump(), testing::Not(HasSubstr(customer_)));
}

TEST_F(ScanIntakeTest, FitsAndMeasuresByItself) {
  Leave();
  StartIntake();
  const std::string scan = WaitResult().at("scan").at("id");
  const JobStatus job = parts_.WaitForJob("J-1");
  ASSERT_EQ(job.state, JobState::kDone) << (job.error ? job.error->Text() : "");
  EXPECT_EQ(job.kind, "fit");
  EXPECT_EQ(job.owner, "anna") << "who armed it";
  EXPECT_EQ(json::parse(job.result_json).at("scan_id"), scan);
  std::vector<std::string> kinds;
  const auto artefacts = parts_.store().ArtefactsOf(scan);
  ASSERT_TRUE(artefacts);
  for (const Artefact& artefact : *artefacts) kinds.push_back(artefact.kind);
  EXPECT_THAT(kinds, testing::IsSupersetOf({"model", "landmarks"}));
  EXPECT_TRUE(parts_.models().Open(scan));
}

TEST_F(ScanIntakeTest, LooksForDriftByItselfAndTwoUpdatesAtOnceLoseNothing) {
  // The history is the names of the scans, a line each: read at once, and written only once `go` is there.
  std::ofstream(folder_ / "drift") << R"(old=$(cat history.json 2>/dev/null)
while [ ! -e ")" << (folder_ / "go")
                                   << R"(" ]; do sleep 0.02; done
[ -z "$old" ] || echo "$old" > history.json
for one in "$@"; do case "$one" in *.mcap) basename "$one" .mcap >> history.json;; esac; done
echo '{"scans_added": 1}'
)";
  Leave();
  StartIntake();
  const std::string first = WaitResult().at("scan").at("id");
  EXPECT_EQ(parts_.WaitForJob("J-1").kind, "fit");
  WaitForState("J-2", JobState::kRunning);
  EXPECT_EQ(parts_.jobs().Get("J-2")->kind, "drift");
  parts_.hub.Forget();
  Leave();
  intake_->ScanEnded(nullptr);
  const std::string second = WaitResult().at("scan").at("id");
  EXPECT_EQ(parts_.WaitForJob("J-3").kind, "fit");
  WaitForState("J-4", JobState::kWaiting);
  const auto third = StartDriftUpdate(parts_.context(), "tom");  // beside the one that the intake has started
  ASSERT_TRUE(third && *third);
  EXPECT_EQ(parts_.jobs().Get("J-2")->state, JobState::kRunning);
  std::ofstream(folder_ / "go") << "go";
  EXPECT_EQ(parts_.WaitForJob("J-4").state, JobState::kDone);
  EXPECT_EQ(parts_.WaitForJob(**third).state, JobState::kDone);
  EXPECT_EQ(json::parse(parts_.jobs().Get(**third)->result_json).at("scans_added"), 0) << "nothing is taken twice";
  EXPECT_EQ(*parts_.store().Setting("drift_history"), first + "\n" + second + "\n");
}

TEST_F(ScanIntakeTest, AnUpdateOfTheDriftThatFailsIsToldToTheTechnicianAndHindersNothing) {
  std::ofstream(folder_ / "drift")
      << "echo 'annulus: look for drift: the history is damaged: restore it' >&2; exit 1\n";
  Leave();
  StartIntake();
  const std::string scan = WaitResult().at("scan").at("id");
  EXPECT_EQ(parts_.WaitForJob("J-1").state, JobState::kDone) << "the fit";
  EXPECT_TRUE(parts_.models().Open(scan));
  EXPECT_EQ(parts_.WaitForJob("J-2").state, JobState::kFailed);
  const auto drift = DriftAnswer(parts_.context());
  ASSERT_TRUE(drift) << drift.error().Text();
  EXPECT_EQ(drift->at("update").at("state"), "failed");
  EXPECT_EQ(drift->at("update").at("error").at("seen"), "the history is damaged");
}

TEST_F(ScanIntakeTest, DoesNotTakeTheSameRecordingTwice) {
  const std::string file = Leave();
  parts_.memory().die_before_removal = true;  // as a console that was killed just then
  StartIntake();
  ASSERT_FALSE(WaitResult().is_null());
  EXPECT_EQ(parts_.WaitForJob("J-1").state, JobState::kDone);
  intake_.reset();
  ASSERT_TRUE(std::filesystem::exists(file));
  StartIntake();
  const auto begin = SystemClock().Now();
  while (std::filesystem::exists(file) && SystemClock().Now() - begin < test::kSoon) std::this_thread::yield();
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_EQ(Scans(), 1U);
}

TEST_F(ScanIntakeTest, FitsWhatWasNotFittedWhenTheConsoleDied) {
  const std::string file = Leave();
  const Scan scan = SmallScan(customer_, consent_);
  ScanRow row;
  row.customer_id = customer_;
  row.consent_id = consent_;
  row.profile = "head";
  row.taken = std::chrono::duration_cast<StoreTime>(SystemClock().WallNow());
  ASSERT_TRUE(parts_.store().AddScan(row, file, nullptr));
  StartIntake();
  const auto begin = SystemClock().Now();
  while (parts_.jobs().All().empty() && SystemClock().Now() - begin < test::kSoon) std::this_thread::yield();
  EXPECT_EQ(parts_.WaitForJob("J-1").state, JobState::kDone);
}

TEST_F(ScanIntakeTest, DeletesWhatItsCustomerDoesNotAllowAnyMore) {
  const std::string file = Leave();
  ASSERT_TRUE(parts_.store().WithdrawConsent(consent_));
  StartIntake();
  const json told = WaitResult();
  EXPECT_THAT(told.at("error").at("seen"), HasSubstr("withdrawn"));
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_EQ(Scans(), 0U);
  const auto audit = *parts_.store().AuditLines(1, 10);
  ASSERT_FALSE(audit.empty());
  EXPECT_EQ(audit.back().action, "recording_deleted");
  EXPECT_EQ(audit.back().subject, customer_);
}

TEST_F(ScanIntakeTest, KeepsWhatTheStoreDoesNotTakeAndTriesAgain) {
  const std::string file = Leave();
  parts_.memory().away = true;
  StartIntake();
  const json told = WaitResult();
  EXPECT_FALSE(told.at("error").is_null());
  EXPECT_TRUE(std::filesystem::exists(file));
  parts_.memory().away = false;
  parts_.hub.Forget();
  intake_->ScanEnded(nullptr);
  EXPECT_TRUE(WaitResult().at("error").is_null());
  EXPECT_EQ(Scans(), 1U);
}

TEST_F(ScanIntakeTest, LeavesWhatItCannotReadOrDoesNotKnow) {
  const std::string damaged = recordings_ + "/T-0123.mcap";
  std::ofstream(damaged) << "no recording";
  const std::string others = recordings_ + "/morning.mcap";
  ASSERT_TRUE(WriteRecording(parts_.storage, others, SmallScan("", "")));
  StartIntake();
  EXPECT_FALSE(WaitResult().at("error").is_null());
  EXPECT_TRUE(std::filesystem::exists(damaged));
  EXPECT_TRUE(std::filesystem::exists(others));
}

TEST_F(ScanIntakeTest, TellsOfAScanThatLeftNoRecording) {
  StartIntake();
  ScanResult result;
  result.status = Fail("scan", "a board was lost", "look at its plug");
  intake_->ScanEnded(&result);
  EXPECT_EQ(WaitResult().at("error").at("seen"), "a board was lost");
}

/// The simulated booth behind the server, in virtual time: whenever the server looks, some of it goes by.
class VirtualBooth final : public BoothPort {
 public:
  VirtualBooth(Config config, const std::string& recordings, LevelMailbox& levels) : config_(std::move(config)) {
    BoothSessionOptions options;
    options.scanner.on_level = [&levels](const ScanLevel& level) { levels.Put(level); };
    auto session = BoothSession::Open(config_, gate_, storage_, std::move(options));
    if (!session) throw std::runtime_error(session.error().Text());
    session_ = std::move(*session);
    BoothDescription description;
    description.station_id = "sim";
    description.simulated = true;
    description.ring_radius_mm = config_.ring.radius_mm;
    description.profiles = {"short"};
    port_ = std::make_unique<ScannerPort>(session_->scanner(), description,
                                          ScannerPortOptions{config_, storage_, recordings, {}});
  }
  [[nodiscard]] const BoothDescription& description() const override { return port_->description(); }
  Status Home() override { return port_->Home(); }
  Status Arm(const ArmOrder& order) override { return port_->Arm(order); }
  Status Start(std::uint64_t version) override { return port_->Start(version); }
  Status Cancel() override { return port_->Cancel(); }
  Status Acknowledge(CauseRole role) override { return port_->Acknowledge(role); }
  Status Jog(Scanner::JogDirection direction) override { return port_->Jog(direction); }
  [[nodiscard]] ScannerStatus status() const override {
    session_->RunUntil([](const ScannerStatus&) { return false; }, std::chrono::milliseconds(100));
    return port_->status();
  }

 private:
  Config config_;
  PosixStorage storage_;
  PermissiveGate gate_;
  std::unique_ptr<BoothSession> session_;
  std::unique_ptr<ScannerPort> port_;
};

/// A whole visit: from the reset to the measured model, all through routes and live messages.
TEST(ScanFromTheConsole, GoesFromConsentToModel) {
  FreshFolder folder;
  const std::string recordings = folder / "recordings";
  std::filesystem::create_directories(recordings);
  Config config = SimulatedConfig();
  config.profiles["short"].z_top_mm = 1300.0;
  config.profiles["short"].z_bottom_mm = 1200.0;
  config.profiles["short"].pitch_mm = 5.0;
  config.profiles["short"].speed_mm_s = 100.0;
  auto levels = std::move(*LevelMailbox::Make());
  VirtualBooth booth(config, recordings, *levels);
  const std::string socket = folder / "booth.sock";
  auto server = std::move(*BoothServer::Make(std::move(*BoothSocket::Listen(socket)), booth, *levels));
  const std::jthread serving([&](const std::stop_token& stop) { server->Serve(stop); });

  ConsoleParts parts(socket, FitProgram(folder));
  RouteCaller routes;
  AddBoothRoutes(routes.table, parts.context());
  AddScanRoutes(routes.table, parts.context());
  const auto intake = ScanIntake::Make(parts.context(), {recordings, nullptr});
  parts.live().OnScanEnded([&](const ScanResult* result) { intake->ScanEnded(result); });
  const auto wait = [&](const std::function<bool(const nlohmann::ordered_json&)>& wanted) {
    const auto message = parts.hub.WaitFor([&](const RecordingHub::Sent& one) {
      return one.message.at("type") == "status" && one.message.at("connected") == true &&
             wanted(one.message.at("status"));
    });
    EXPECT_FALSE(message.is_null());
    return message;
  };
  const auto [customer, consent] = parts.Somebody();

  wait([](const auto& status) { return status.at("state") == "IDLE"; });
  ASSERT_EQ(routes.Post("/api/booth/home").status, 200);
  const auto homed =
      wait([](const auto& status) { return status.at("homed") == true && status.at("state") == "IDLE"; });
  ASSERT_FALSE(homed.is_null());
  EXPECT_EQ(homed.at("plain").at("ready"), true);
  const json arm{{"customer_id", customer}, {"consent_id", consent}, {"profile", "short"}};
  const Answer armed = routes.Post("/api/booth/arm", arm);
  ASSERT_EQ(armed.status, 200) << armed.seen;
  const auto ready = wait([](const auto& status) { return status.at("state") == "ARMED"; });
  ASSERT_FALSE(ready.is_null()) << parts.hub.all().back().message.dump(1);
  const int presses = ready.at("status").at("start_presses");
  const auto pressed =
      wait([&](const auto& status) { return status.at("state") == "ARMED" && status.at("start_presses") > presses; });
  ASSERT_FALSE(pressed.is_null());
  const Answer started = routes.Post("/api/booth/start", {{"version", pressed.at("status").at("version")}});
  ASSERT_EQ(started.status, 200) << started.seen;

  const auto told = parts.hub.WaitForType("scan_result");
  ASSERT_FALSE(told.is_null());
  ASSERT_TRUE(told.at("error").is_null()) << told.dump();
  const std::string scan = told.at("scan").at("id");
  EXPECT_EQ(told.at("scan").at("summary").at("levels"), told.at("scan").at("summary").at("planned_levels"));
  const auto sent = parts.hub.all();
  EXPECT_TRUE(std::any_of(sent.begin(), sent.end(), [](const RecordingHub::Sent& one) {
    return one.message.at("type") == "level" && one.roles.operator_ && !one.roles.none;
  })) << "the body grows while it is scanned";
  EXPECT_EQ(parts.WaitForJob("J-1").state, JobState::kDone);
  const Answer got = routes.Get("/api/scans/" + scan);
  EXPECT_EQ(got.json.at("customer_id"), customer);
  EXPECT_EQ(got.json.at("model"), true);
  EXPECT_TRUE(std::filesystem::is_empty(recordings));
  parts.live().OnScanEnded({});
}

}  // namespace
}  // namespace annulus
