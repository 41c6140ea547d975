#include "station/booth_server.h"

#include <sys/socket.h>

#include <cmath>

#include "tests/station/served_booth.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using test::InState;
using test::kSoon;
using test::ReadRaw;
using test::SendRaw;
using test::ServedBooth;
using testing::HasSubstr;

milliseconds Since(std::chrono::nanoseconds begin) {
  return std::chrono::duration_cast<milliseconds>(SystemClock().Now() - begin);
}

bool IsBye(const BoothMessage& message) { return std::holds_alternative<ByeMessage>(message); }
auto IsReply(std::uint64_t id) {
  return [id](const BoothMessage& message) {
    const auto* reply = std::get_if<ReplyMessage>(&message);
    return reply != nullptr && reply->id == id;
  };
}

/// Into ARMED; the version to start with.
std::uint64_t ArmedBy(BoothClient& client, ServedBooth& booth) {
  EXPECT_TRUE(client.Ask(HomeOrder{}, kSoon));
  EXPECT_TRUE(booth.port().Tell(ScanEventKind::kHomed));
  EXPECT_TRUE(client.WaitFor(InState(ScanState::kIdle), kSoon));
  EXPECT_TRUE(client.Ask(ArmOrder{"body", {}, false, "a.mcap", "s-1", "c-1"}, kSoon));
  EXPECT_TRUE(client.WaitFor(InState(ScanState::kArmed), kSoon));
  return client.status().scanner.version;
}

TEST(BoothServer, WelcomesAClientAndTellsItBoothAndStatus) {
  ServedBooth booth;
  const BoothClient client = booth.Viewer();
  EXPECT_EQ(client.booth().station_id, "test");
  EXPECT_EQ(client.booth().boards.size(), 2U);
  EXPECT_EQ(client.booth().axis.z_max, Millimetres(2250.0));
  EXPECT_FALSE(client.controls());
  EXPECT_EQ(client.status().scanner.state, ScanState::kIdle);
  EXPECT_FALSE(client.status().controlled);
  EXPECT_EQ(client.status().sessions, 1U);
}

TEST(BoothServer, CarriesAScanFromHomingToItsResult) {
  ServedBooth booth;
  BoothClient client = booth.Operator();
  const std::uint64_t version = ArmedBy(client, booth);
  EXPECT_EQ(booth.port().armed().subject_id, "s-1");
  ASSERT_TRUE(client.Ask(StartOrder{version}, kSoon));
  ASSERT_TRUE(client.WaitFor(InState(ScanState::kScanning), kSoon));
  ASSERT_TRUE(booth.port().Tell(ScanEventKind::kLastLevel));
  ASSERT_TRUE(booth.port().Tell(ScanEventKind::kStopped));
  booth.port().Change([](ScannerStatus& status) {
    ScanResult result;
    result.number = 7;
    result.recording = "/scans/a.mcap";
    result.complete = true;
    status.scan = result;
  });
  int results = 0;
  const auto deadline = SystemClock().Now() + milliseconds(1200);
  while (SystemClock().Now() < deadline) {
    const auto message = client.Next(milliseconds(100));
    ASSERT_TRUE(message) << message.error().Text();
    if (!*message) continue;
    if (const auto* came = std::get_if<ResultMessage>(&**message)) {
      ++results;
      EXPECT_EQ(came->result.number, 7U);
      EXPECT_EQ(came->result.recording, "/scans/a.mcap");
    }
  }
  EXPECT_EQ(results, 1) << "it is news once";
  EXPECT_TRUE(client.status().scanner.scan.has_value()) << "and in every status";
}

TEST(BoothServer, GivesControlToOneSessionAtATime) {
  ServedBooth booth;
  auto first = std::make_unique<BoothClient>(booth.Operator());
  EXPECT_TRUE(first->controls());
  const auto second = booth.TryConnect({BoothRole::kTechnician, true, "second"});
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().Text(), HasSubstr("another session controls"));
  first.reset();
  BoothClient viewer = booth.Viewer();
  ASSERT_TRUE(viewer.WaitFor([](const StatusMessage& status) { return !status.controlled; }, kSoon));
  EXPECT_TRUE(booth.Technician().controls());
}

TEST(BoothServer, AllowsOnlyCancelToWhoLooksOn) {
  ServedBooth booth;
  BoothClient viewer = booth.Viewer();
  for (const BoothOrder& order : {BoothOrder(HomeOrder{}), BoothOrder(ArmOrder{"body", {}, false, "a", "", ""}),
                                  BoothOrder(StartOrder{1}), BoothOrder(AcknowledgeOrder{}), BoothOrder(JogOrder{})}) {
    const Status refused = viewer.Ask(order, kSoon);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().Text(), HasSubstr("only looks on"));
  }
  EXPECT_EQ(booth.port().status().state, ScanState::kIdle);
  ASSERT_TRUE(booth.port().Home());
  EXPECT_TRUE(viewer.Ask(CancelOrder{}, kSoon));
  EXPECT_EQ(booth.port().status().state, ScanState::kStopping);
}

TEST(BoothServer, TakesACancelBeforeHelloAndFromWhoHangsUpAtOnce) {
  ServedBooth booth;
  ASSERT_TRUE(booth.port().Home());
  {
    const auto raw = booth.Raw();
    ASSERT_TRUE(SendRaw(raw, R"({"v":1,"id":1,"type":"home"})"));
    ASSERT_TRUE(SendRaw(raw, R"({"v":1,"id":2,"type":"cancel"})"));
  }
  const auto begin = SystemClock().Now();
  while (booth.port().status().state != ScanState::kStopping && Since(begin) < kSoon) std::this_thread::yield();
  EXPECT_EQ(booth.port().status().state, ScanState::kStopping);
}

TEST(BoothServer, LetsOnlyATechnicianJog) {
  ServedBooth booth;
  {
    BoothClient client = booth.Operator();
    const Status refused = client.Ask(JogOrder{Scanner::JogDirection::kDown}, kSoon);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().Text(), HasSubstr("operator"));
  }
  BoothClient viewer = booth.Viewer();
  ASSERT_TRUE(viewer.WaitFor([](const StatusMessage& status) { return !status.controlled; }, kSoon));
  BoothClient technician = booth.Technician();
  EXPECT_TRUE(technician.Ask(JogOrder{Scanner::JogDirection::kDown}, kSoon));
  EXPECT_EQ(booth.port().status().state, ScanState::kJog);
}

TEST(BoothServer, EndsAJogAtOnceWhenItsSessionIsGone) {
  ServedBooth booth;
  BoothClient viewer = booth.Viewer();
  auto technician = std::make_unique<BoothClient>(booth.Technician());
  ASSERT_TRUE(technician->Ask(JogOrder{}, kSoon));
  ASSERT_TRUE(viewer.WaitFor(InState(ScanState::kJog), kSoon));
  technician.reset();
  // The machine is not asked what is due here: that it stops is the server's doing.
  EXPECT_TRUE(viewer.WaitFor(InState(ScanState::kStopping), kSoon));
}

TEST(BoothServer, LetsAScanGoOnWhenItsSessionIsGone) {
  ServedBooth booth;
  BoothClient viewer = booth.Viewer();
  auto client = std::make_unique<BoothClient>(booth.Operator());
  ASSERT_TRUE(client->Ask(StartOrder{ArmedBy(*client, booth)}, kSoon));
  ASSERT_TRUE(viewer.WaitFor([](const StatusMessage& status) { return status.controlled; }, kSoon));
  client.reset();
  ASSERT_TRUE(viewer.WaitFor([](const StatusMessage& status) { return !status.controlled; }, kSoon));
  EXPECT_EQ(viewer.status().scanner.state, ScanState::kScanning);
  BoothClient next = booth.Operator();
  EXPECT_TRUE(next.Ask(CancelOrder{}, kSoon)) << "and whoever comes next can stop it";
}

TEST(BoothServer, AcknowledgesInTheRoleOfTheSession) {
  ServedBooth booth;
  booth.port().Fault({CauseCode::kBrakeSlip, "the axis sinks", "call service", {}});
  {
    BoothClient client = booth.Operator();
    EXPECT_FALSE(client.Ask(AcknowledgeOrder{}, kSoon));
    ASSERT_EQ(client.status().scanner.causes.size(), 1U);
    EXPECT_EQ(client.status().scanner.causes[0].code, CauseCode::kBrakeSlip);
  }
  BoothClient viewer = booth.Viewer();
  ASSERT_TRUE(viewer.WaitFor([](const StatusMessage& status) { return !status.controlled; }, kSoon));
  BoothClient technician = booth.Technician();
  EXPECT_TRUE(technician.Ask(AcknowledgeOrder{}, kSoon));
  EXPECT_EQ(booth.port().status().state, ScanState::kIdle);
}

// RELIABILITY N2, N3.
TEST(BoothServer, MakesOneScanOfManyStartsAndRefusesStaleOnes) {
  ServedBooth booth;
  BoothClient client = booth.Operator();
  const std::uint64_t version = ArmedBy(client, booth);
  const Status stale = client.Ask(StartOrder{version - 1}, kSoon);
  ASSERT_FALSE(stale);
  EXPECT_THAT(stale.error().Text(), HasSubstr("has changed"));
  EXPECT_EQ(booth.port().scans(), 0U);
  int accepted = 0;
  for (int k = 0; k < 20; ++k) accepted += client.Ask(StartOrder{version}, kSoon) ? 1 : 0;
  EXPECT_EQ(accepted, 1);
  EXPECT_EQ(booth.port().scans(), 1U);
  // The same order once more, when the booth is ready for the next scan.
  ASSERT_TRUE(booth.port().Tell(ScanEventKind::kLastLevel));
  ASSERT_TRUE(booth.port().Tell(ScanEventKind::kStopped));
  ASSERT_TRUE(client.Ask(ArmOrder{"body", {}, false, "b.mcap", "s-2", "c-2"}, kSoon));
  const Status replayed = client.Ask(StartOrder{version}, kSoon);
  ASSERT_FALSE(replayed);
  EXPECT_THAT(replayed.error().Text(), HasSubstr("has changed"));
  EXPECT_EQ(booth.port().scans(), 1U);
}

TEST(BoothServer, TellsOfAChangeSoonAndOfNoChangeEveryHalfSecond) {
  ServedBooth booth;
  BoothClient viewer = booth.Viewer();
  milliseconds soonest = kSoon;
  for (const std::string warning : {"a", "b", "c", "d", "e"}) {
    const auto begin = SystemClock().Now();
    booth.port().Change([&](ScannerStatus& status) { status.warnings = {{WarningCode::kOther, warning, {}}}; });
    const auto told = [&](const StatusMessage& message) {
      return message.scanner.warnings == std::vector<ScanWarning>{{WarningCode::kOther, warning, {}}};
    };
    ASSERT_TRUE(viewer.WaitFor(told, kSoon));
    soonest = std::min(soonest, Since(begin));
  }
  EXPECT_LT(soonest, milliseconds(300)) << "sooner than the next one would have come anyhow";
  int statuses = 0;
  const auto begin = SystemClock().Now();
  while (statuses < 3 && Since(begin) < kSoon) {
    const auto message = viewer.Next(kSoon);
    ASSERT_TRUE(message && *message);
    statuses += std::holds_alternative<StatusMessage>(**message) ? 1 : 0;
  }
  EXPECT_EQ(statuses, 3);
  EXPECT_GE(Since(begin), milliseconds(900)) << "three in a row, two waits";
}

ScanLevel MakeLevel(std::uint32_t index) {
  ScanLevel level{index, 2, std::chrono::nanoseconds(5), {}};
  for (int sensor = 0; sensor < 180; ++sensor) level.readings.push_back({300.0 + sensor, 1000.0 + sensor % 3, 200});
  level.readings[4].range_mm = std::nan("");
  return level;
}

TEST(BoothServer, PassesEveryNthLevelAndMthReading) {
  ServedBooth booth;
  BoothClient viewer = booth.Viewer();
  ASSERT_TRUE(viewer.Ask(SubscribeOrder{3, 4}, kSoon));
  for (std::uint32_t index = 0; index < 10; ++index) booth.levels().Put(MakeLevel(index));
  std::vector<LevelMessage> levels;
  while (levels.size() < 4) {
    const auto message = viewer.Next(kSoon);
    ASSERT_TRUE(message && *message);
    if (const auto* level = std::get_if<LevelMessage>(&**message)) levels.push_back(*level);
  }
  for (std::uint32_t k = 0; k < 4; ++k) {
    EXPECT_EQ(levels[k].level, 3 * k);
    EXPECT_EQ(levels[k].sweep, 2U);
    EXPECT_DOUBLE_EQ(levels[k].z_mm, 1001.0);
    EXPECT_EQ(levels[k].sensor_step, 4U);
    ASSERT_EQ(levels[k].range_mm.size(), 45U);
    EXPECT_DOUBLE_EQ(levels[k].range_mm[2], 308.0);
    EXPECT_TRUE(std::isnan(levels[k].range_mm[1]));
  }
}

// RELIABILITY N4.
TEST(BoothServer, DropsWhoDoesNotReadAndNobodyElse) {
  ServedBooth booth;
  BoothClient viewer = booth.Viewer();
  const auto stuck = booth.Raw();
  ASSERT_TRUE(SendRaw(stuck, R"({"v":1,"id":1,"type":"hello","role":"operator","control":false})"));
  ASSERT_TRUE(SendRaw(stuck, R"({"v":1,"id":2,"type":"subscribe","levels":1})"));
  ASSERT_TRUE(viewer.WaitFor([](const StatusMessage& status) { return status.sessions == 2; }, kSoon));
  // Whoever takes levels is never held up: what cannot be shown is dropped.
  std::chrono::nanoseconds longest{0};
  const auto begin = SystemClock().Now();
  std::uint32_t put = 0;
  while (viewer.status().sessions == 2 && Since(begin) < 4 * kSoon) {
    for (int k = 0; k < 50; ++k) {
      const auto before = SystemClock().Now();
      booth.levels().Put(MakeLevel(put++));
      longest = std::max(longest, SystemClock().Now() - before);
    }
    ASSERT_TRUE(viewer.Next(milliseconds(5)));
  }
  EXPECT_EQ(viewer.status().sessions, 1U) << "after " << put << " levels";
  EXPECT_LT(longest, std::chrono::seconds(1));
  EXPECT_TRUE(viewer.Ask(StatusOrder{}, kSoon));
}

// RELIABILITY N5.
TEST(BoothServer, RefusesAFloodButNotTheCancelInIt) {
  ServedBooth booth;
  ASSERT_TRUE(booth.port().Home());
  const auto flood = booth.Raw();
  ASSERT_TRUE(SendRaw(flood, R"({"v":1,"id":1,"type":"hello","role":"operator","control":true})"));
  ASSERT_TRUE(test::SendRawAtOnce(flood, R"({"v":1,"id":2,"type":"subscribe","levels":0})", 500));
  ASSERT_TRUE(SendRaw(flood, R"({"v":1,"id":3,"type":"cancel"})"));
  int refused = 0;
  for (const BoothMessage& message : ReadRaw(flood, IsReply(3))) {
    const auto* reply = std::get_if<ReplyMessage>(&message);
    if (reply != nullptr && reply->id == 2 && !reply->result) ++refused;
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, 400) << "a burst of 200 is nobody's fault";
  EXPECT_EQ(booth.port().status().state, ScanState::kStopping);
  // Whoever goes on is thrown out.
  std::thread more([&] {
    for (int k = 0; k < 5000 && SendRaw(flood, R"({"v":1,"id":4,"type":"status"})"); ++k) {
    }
  });
  const auto messages = ReadRaw(flood, IsBye);
  more.join();
  ASSERT_FALSE(messages.empty());
  ASSERT_TRUE(IsBye(messages.back()));
  EXPECT_EQ(std::get<ByeMessage>(messages.back()).reason, "too many requests");
}

TEST(BoothServer, AnswersDamagedRequestsAndHangsUpOnDamagedFrames) {
  ServedBooth booth;
  const auto raw = booth.Raw();
  for (const char* damaged : {"nonsense", "[]", "{}", R"({"v":2,"id":5,"type":"home"})", R"({"v":1,"id":5})"}) {
    ASSERT_TRUE(SendRaw(raw, damaged));
    const auto messages = ReadRaw(raw, [](const BoothMessage&) { return true; });
    ASSERT_EQ(messages.size(), 1U) << damaged;
    const auto* reply = std::get_if<ReplyMessage>(&messages.front());
    ASSERT_NE(reply, nullptr) << damaged;
    EXPECT_FALSE(reply->result) << damaged;
  }
  const std::string overlong("\xFF\xFF\xFF\x7F", 4);
  ASSERT_EQ(::send(raw.get(), overlong.data(), overlong.size(), MSG_NOSIGNAL), 4);
  const auto messages = ReadRaw(raw, IsBye);
  ASSERT_FALSE(messages.empty());
  EXPECT_TRUE(IsBye(messages.back()));
  char byte = 0;
  EXPECT_EQ(::recv(raw.get(), &byte, 1, 0), 0) << "closed";
}

TEST(BoothServer, TakesSixteenViewersAndStillTheOneWhoControls) {
  ServedBooth booth;
  std::vector<BoothClient> viewers;
  for (std::size_t k = 0; k < booth_limit::kViewers; ++k) viewers.push_back(booth.Viewer());
  const auto one_more = booth.TryConnect({BoothRole::kOperator, false, "one more"});
  ASSERT_FALSE(one_more);
  EXPECT_THAT(one_more.error().Text(), HasSubstr("look on already"));
  BoothClient client = booth.Operator();
  EXPECT_EQ(client.status().sessions, booth_limit::kViewers + 1);
}

TEST(BoothServer, RefusesConnectionsBeyondItsLimit) {
  ServedBooth booth;
  std::vector<sim::OwnedFd> silent;
  for (std::size_t k = 0; k < booth_limit::kConnections; ++k) silent.push_back(booth.Raw());
  const auto last = booth.Raw();
  const auto messages = ReadRaw(last, IsBye);
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_THAT(std::get<ByeMessage>(messages[0]).reason, HasSubstr("too many connections"));
  // Who says nothing is not kept for ever.
  const auto dropped = ReadRaw(silent.front(), IsBye);
  ASSERT_EQ(dropped.size(), 1U);
  EXPECT_THAT(std::get<ByeMessage>(dropped[0]).reason, HasSubstr("no hello"));
}

TEST(BoothServer, SaysGoodbyeWhenItEnds) {
  ServedBooth booth;
  BoothClient viewer = booth.Viewer();
  booth.End();
  auto message = viewer.Next(kSoon);
  while (message && *message) message = viewer.Next(kSoon);
  ASSERT_FALSE(message);
  EXPECT_THAT(message.error().Text(), HasSubstr("boothd ends"));
  EXPECT_FALSE(std::filesystem::exists(booth.path()));
  EXPECT_FALSE(std::filesystem::exists(booth.path() + ".lock"));
}

}  // namespace
}  // namespace annulus
