#include "station/booth_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

namespace annulus {
namespace {

using testing::HasSubstr;
using Json = nlohmann::ordered_json;

template <class Order>
Order Read(const std::string& json) {
  const auto request = DecodeRequest(json);
  EXPECT_TRUE(request) << json << ": " << request.error().error.Text();
  if (!request || !std::holds_alternative<Order>(request->order)) {
    ADD_FAILURE() << json;
    return {};
  }
  return std::get<Order>(request->order);
}

TEST(BoothMessages, ReadEveryOrderOfTheProtocol) {
  const auto hello =
      Read<HelloOrder>(R"({"v":1,"id":1,"type":"hello","role":"technician","control":true,"client":"console 3"})");
  EXPECT_EQ(hello.role, BoothRole::kTechnician);
  EXPECT_TRUE(hello.control);
  EXPECT_EQ(hello.client, "console 3");
  Read<HomeOrder>(R"({"v":1,"id":1,"type":"home"})");
  const auto arm = Read<ArmOrder>(
      R"({"v":1,"id":1,"type":"arm","profile":"head","height_mm":1712.5,"out":"a/b.mcap","subject_id":"s","consent":"c"})");
  EXPECT_EQ(arm.profile, "head");
  EXPECT_EQ(arm.height, Millimetres(1712.5));
  EXPECT_FALSE(arm.search);
  EXPECT_EQ(arm.out, "a/b.mcap");
  EXPECT_EQ(arm.subject_id, "s");
  EXPECT_EQ(arm.consent, "c");
  const auto search = Read<ArmOrder>(R"({"v":1,"id":1,"type":"arm","profile":"head","search":true})");
  EXPECT_TRUE(search.search);
  EXPECT_FALSE(search.height);
  EXPECT_EQ(Read<StartOrder>(R"({"v":1,"id":1,"type":"start","version":18446744073709551615})").version,
            18'446'744'073'709'551'615U);
  Read<CancelOrder>(R"({"v":1,"id":1,"type":"cancel"})");
  Read<AcknowledgeOrder>(R"({"v":1,"id":1,"type":"acknowledge"})");
  EXPECT_EQ(Read<JogOrder>(R"({"v":1,"id":1,"type":"jog","direction":"down"})").direction,
            Scanner::JogDirection::kDown);
  EXPECT_EQ(Read<JogOrder>(R"({"v":1,"id":1,"type":"jog","direction":"up"})").direction, Scanner::JogDirection::kUp);
  const auto subscribe = Read<SubscribeOrder>(R"({"v":1,"id":1,"type":"subscribe","levels":5,"sensors":6})");
  EXPECT_EQ(subscribe.levels, 5U);
  EXPECT_EQ(subscribe.sensors, 6U);
  Read<StatusOrder>(R"({"v":1,"id":1,"type":"status"})");
}

TEST(BoothMessages, SkipWhatANewerProgramAdds) {
  Read<CancelOrder>(R"({"v":1,"id":1,"type":"cancel","why":{"a":[1,2,{"b":null}]}})");
  EXPECT_EQ(Read<UnknownOrder>(R"({"v":1,"id":9,"type":"dance"})").type, "dance");
  const auto message = DecodeMessage(R"({"v":1,"type":"weather","rain":true})");
  ASSERT_TRUE(message);
  EXPECT_EQ(std::get<UnknownMessage>(*message).type, "weather");
}

TEST(BoothMessages, NameWhatIsWrongWithARequest) {
  const std::string head = R"({"v":1,"id":3,"type":)";
  const std::vector<std::pair<std::string, std::string>> cases{
      {head + R"("hello","role":"operator"})", "'control' is missing"},
      {head + R"("hello","role":"king","control":true})", "'role' is neither operator nor technician"},
      {head + R"("hello","role":"operator","control":1})", "'control' is of type number"},
      {head + R"("start"})", "'version' is missing"},
      {head + R"("start","version":-1})", "'version' is of type number, not a whole number from 0"},
      {head + R"("start","version":"7"})", "'version' is of type string"},
      {head + R"("start","version":1.5})", "'version'"},
      {head + R"("jog","direction":"left"})", "'direction' is neither up nor down"},
      {head + R"("arm","profile":"head"})", "'out' is missing"},
      {head + R"("arm","profile":"head","out":""})", "'out' is empty"},
      {head + R"("arm","profile":"head","out":"a\u0000b"})", "'out' is text with control characters"},
      {head + R"("arm","profile":"head","out":"a","height_mm":5})", "'height_mm' is not a number from 300.0 to 2500.0"},
      {head + R"("arm","profile":"head","out":"a","height_mm":"tall"})", "'height_mm' is of type string"},
      {head + R"("arm","profile":")" + std::string(65, 'p') + R"(","out":"a"})", "'profile' is of 65 bytes"},
      {head + R"("arm","profile":"p","out":"a","subject_id":[]})", "'subject_id' is of type array"},
      {head + R"("subscribe","levels":10001})", "'levels' is 10001, not at most 10000"},
      {head + R"("subscribe","levels":1,"sensors":0})", "'sensors' is 0"},
      {head + "7}", "'type' is of type number"},
  };
  for (const auto& [json, named] : cases) {
    const auto request = DecodeRequest(json);
    ASSERT_FALSE(request) << json;
    EXPECT_THAT(request.error().error.seen, HasSubstr(named)) << json;
    EXPECT_EQ(request.error().id, 3U) << json;
  }
}

TEST(BoothMessages, RefuseWhatIsNoRequestAtAll) {
  for (const std::string json :
       {"", "x", "null", "[]", "\"text\"", "{", "{\"v\":1", "{\"v\":1,\"id\":1,\"type\":\"home\"} x",
        "{\"v\":1,\"id\":1,\"type\":\"\xFF\xFE\"}"}) {
    EXPECT_FALSE(DecodeRequest(json)) << json;
    EXPECT_FALSE(DecodeMessage(json)) << json;
  }
  const auto newer = DecodeRequest(R"({"v":2,"id":4,"type":"home"})");
  ASSERT_FALSE(newer);
  EXPECT_EQ(newer.error().id, 4U);
  EXPECT_THAT(newer.error().error.seen, HasSubstr("'v' is 2, not 1"));
}

TEST(BoothMessages, RefuseDeepNestingBeforeItIsRead) {
  const std::string deep = R"({"v":1,"id":1,"type":"home","a":)" + std::string(100'000, '[');
  const auto refused = DecodeRequest(deep);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().error.seen, HasSubstr("nested"));
  // Brackets in texts are none, also behind an escaped quote.
  const std::string text = R"({"v":1,"id":1,"type":"home","a":"\")" + std::string(1000, '[') + "\"}";
  EXPECT_TRUE(DecodeRequest(text));
  EXPECT_FALSE(DecodeMessage(std::string(kMaxBoothMessage + 1, ' ')));
}

/// A status in which every field has a value of its own.
StatusMessage FullStatus() {
  StatusMessage message;
  message.controlled = true;
  message.sessions = 3;
  ScannerStatus& s = message.scanner;
  s.state = ScanState::kFault;
  s.version = 41;
  s.homed = true;
  s.causes = {{CauseCode::kSensorLost, "board 1004 is gone", "plug it in", std::chrono::nanoseconds(123'456'789'012)},
              {CauseCode::kBrakeSlip, "the axis sinks", "call service", std::chrono::nanoseconds(5)}};
  s.held_by = "door";
  s.chain = {{InterlockFault::kLampLost, std::chrono::nanoseconds(77), true, "lamp", "change it"}};
  s.warnings = {{WarningCode::kDiskSlow, "slow disk", {}},
                {WarningCode::kRingTemperature, "38 degrees, 20 then", {38.0, 20.5}}};
  s.job = "scan";
  s.stage = "sweep 2 of 4";
  s.done = 12.5;
  s.total = 100.0;
  s.start_presses = 9;
  s.z_mm = 1234.5678;
  ArmReport arm;
  arm.checks = {{"homed", {}}, {"disk", Fail("reserve room", "1 MB is free", "delete something")}};
  arm.plan_adjusted = {"slower"};
  s.arm = arm;
  ScanResult scan;
  scan.number = 6;
  scan.status = Fail("scan", "board lost", "plug it in");
  scan.plan = {"body", 1850.0, 50.0, 5.0, 300.0, 4, 30.0, 0.25};
  scan.summary = {true, 720, 500, 2, 3, std::chrono::nanoseconds(10), std::chrono::nanoseconds(20), 90'000, 7, {}, 1.5};
  scan.summary.ring = {500, 1, 2, 3, 4, 5};
  scan.recorded = true;
  scan.recording = "/scans/s-1.mcap";
  scan.top = Millimetres(1801.0);
  s.scan = scan;
  s.longest_tick = std::chrono::nanoseconds(10'400'000);
  return message;
}

TEST(BoothMessages, TellEverythingOfTheStatus) {
  const Json json = Json::parse(EncodeMessage(FullStatus()));
  EXPECT_EQ(json["v"], 1);
  EXPECT_EQ(json["type"], "status");
  EXPECT_EQ(json["state"], "FAULT");
  EXPECT_EQ(json["version"], 41);
  EXPECT_EQ(json["homed"], true);
  EXPECT_EQ(json["causes"][0], Json::parse(R"({"code":"sensor_lost","role":"operator","text":"board 1004 is gone",
      "advice":"plug it in","time_ns":123456789012})"));
  EXPECT_EQ(json["causes"][1]["role"], "service");
  EXPECT_EQ(json["held_by"], "door");
  EXPECT_EQ(json["chain"][0]["fault"], "lamp_lost");
  EXPECT_EQ(json["warnings"], Json::parse(R"([{"code":"disk_slow","text":"slow disk","values":[]},
      {"code":"ring_temperature","text":"38 degrees, 20 then","values":[38.0,20.5]}])"));
  EXPECT_EQ(json["job"], "scan");
  EXPECT_EQ(json["stage"], "sweep 2 of 4");
  EXPECT_EQ(json["done"], 12.5);
  EXPECT_EQ(json["total"], 100.0);
  EXPECT_EQ(json["start_presses"], 9);
  EXPECT_EQ(json["z_mm"], 1234.5678);
  EXPECT_EQ(json["arm"]["passed"], false);
  EXPECT_EQ(json["arm"]["checks"][0]["error"], nullptr);
  EXPECT_EQ(json["arm"]["checks"][1]["error"]["seen"], "1 MB is free");
  EXPECT_EQ(json["scan"]["plan"]["level_rate_hz"], 30.0);
  EXPECT_EQ(json["scan"]["summary"]["planned_levels"], 720);
  EXPECT_EQ(json["scan"]["summary"]["ring"]["overflowed_frames"], 5);
  EXPECT_EQ(json["scan"]["top_mm"], 1801.0);
  EXPECT_EQ(json["longest_tick_ns"], 10'400'000);
  EXPECT_EQ(json["controlled"], true);
  EXPECT_EQ(json["sessions"], 3);
}

TEST(BoothMessages, ReadAStatusAsItWasTold) {
  const auto message = DecodeMessage(EncodeMessage(FullStatus()));
  ASSERT_TRUE(message) << message.error().Text();
  const ScannerStatus s = std::get<StatusMessage>(*message).scanner;
  EXPECT_EQ(s.state, ScanState::kFault);
  EXPECT_EQ(s.version, 41U);
  ASSERT_EQ(s.causes.size(), 2U);
  EXPECT_EQ(s.causes[0].code, CauseCode::kSensorLost);
  EXPECT_EQ(s.causes[0].time, std::chrono::nanoseconds(123'456'789'012));
  ASSERT_EQ(s.chain.size(), 1U);
  EXPECT_EQ(s.chain[0].fault, InterlockFault::kLampLost);
  EXPECT_TRUE(s.chain[0].present);
  EXPECT_EQ(s.z_mm, 1234.5678);
  ASSERT_TRUE(s.arm);
  EXPECT_TRUE(s.arm->checks[0].result);
  EXPECT_EQ(s.arm->checks[1].result.error().advice, "delete something");
  ASSERT_TRUE(s.scan);
  EXPECT_EQ(s.scan->status.error().seen, "board lost");
  EXPECT_EQ(s.scan->plan.sweeps, 4U);
  EXPECT_TRUE(s.scan->summary.cancelled);
  EXPECT_EQ(s.scan->summary.ring.rejected_bytes, 4U);
  EXPECT_EQ(s.scan->top, Millimetres(1801.0));
  EXPECT_EQ(EncodeMessage(*message), EncodeMessage(FullStatus()));
}

TEST(BoothMessages, KeepNumbersThatAreNone) {
  LevelMessage level{3, 1, std::chrono::nanoseconds(9), std::nan(""), 2, {310.004, std::nan(""), 1e300}};
  const Json json = Json::parse(EncodeMessage(level));
  EXPECT_EQ(json["z_mm"], nullptr);
  EXPECT_EQ(json["range_mm"][0], 310.0);
  EXPECT_EQ(json["range_mm"][1], nullptr);
  const auto message = DecodeMessage(json.dump());
  ASSERT_TRUE(message);
  const auto& read = std::get<LevelMessage>(*message);
  EXPECT_TRUE(std::isnan(read.z_mm));
  EXPECT_TRUE(std::isnan(read.range_mm[1]));
}

TEST(BoothMessages, CutTextsAtACharacterAndReplaceBadBytes) {
  ReplyMessage reply{1, Fail("\xFF", std::string(1023, 'a') + "\xC3\xA9", "")};
  const Json json = Json::parse(EncodeMessage(reply));
  EXPECT_EQ(json["error"]["attempted"], "\xEF\xBF\xBD");
  EXPECT_EQ(json["error"]["seen"], std::string(1023, 'a'));
}

TEST(BoothMessages, SurviveDamageAnywhere) {
  std::mt19937 random(7);
  const std::string whole = EncodeMessage(FullStatus());
  const std::string order = EncodeRequest({3, ArmOrder{"head", Millimetres(1700.0), false, "a", "s", "c"}});
  for (int k = 0; k < 4000; ++k) {
    std::string text = k % 2 == 0 ? whole : order;
    const std::size_t edits = 1 + random() % 3;
    for (std::size_t edit = 0; edit < edits; ++edit) {
      text[random() % text.size()] = "\"{}[],:0919-+.eE\\x \xC3"[random() % 22];
    }
    if (random() % 4 == 0) text.resize(random() % text.size());
    const auto message = DecodeMessage(text);
    EXPECT_TRUE(!message || DecodeMessage(EncodeMessage(*message))) << text;
    const auto request = DecodeRequest(text);
    EXPECT_TRUE(!request || DecodeRequest(EncodeRequest(*request))) << text;
  }
}

// The frame of docs/wire_protocol.md, byte by byte.
TEST(BoothFrames, AreALengthAndSoManyBytes) {
  const std::string json = R"({"v":1,"type":"cancel","id":7})";
  EXPECT_EQ(EncodeRequest({7, CancelOrder{}}), json);
  const auto frame = BoothFrame(json);
  ASSERT_TRUE(frame);
  EXPECT_EQ(*frame, std::string("\x1E\0\0\0", 4) + json);
  EXPECT_FALSE(BoothFrame(""));
  EXPECT_FALSE(BoothFrame(std::string(kMaxBoothMessage + 1, 'x')));
}

TEST(BoothFrames, ComeInPiecesOfAnySize) {
  std::string stream;
  std::vector<std::string> texts;
  std::mt19937 random(1);
  for (std::size_t k = 0; k < 300; ++k) {
    texts.emplace_back(1 + random() % 1000, static_cast<char>('a' + k % 26));
    stream += *BoothFrame(texts.back());
  }
  for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, std::size_t{4096}, stream.size()}) {
    BoothFrameReader reader(1000);
    std::vector<std::string> read;
    for (std::size_t begin = 0; begin < stream.size(); begin += piece) {
      reader.Append(std::string_view(stream).substr(begin, piece));
      while (auto text = *reader.Next()) read.push_back(*text);
    }
    EXPECT_EQ(read, texts);
    EXPECT_EQ(reader.waiting(), 0U);
  }
}

TEST(BoothFrames, OfNoLengthOrTooLongAreRefused) {
  BoothFrameReader reader(10);
  reader.Append(std::string_view("\x0A\0\0\0", 4));
  ASSERT_TRUE(reader.Next());
  EXPECT_FALSE(*reader.Next());
  reader.Append("0123456789");
  EXPECT_EQ(**reader.Next(), "0123456789");
  for (const auto& prefix : {std::string("\x0B\0\0\0", 4), std::string(4, '\0'), std::string(4, '\xFF')}) {
    BoothFrameReader damaged(10);
    damaged.Append(prefix);
    EXPECT_FALSE(damaged.Next());
    EXPECT_FALSE(damaged.Next()) << "and stays so";
  }
}

}  // namespace
}  // namespace annulus
