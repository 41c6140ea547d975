#include "acquisition/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "base/sha256.h"
#include "tests/acquisition/calibration_fixture.h"
#include "tests/support/test_storage.h"

namespace annulus {
namespace {

using Json = nlohmann::ordered_json;
using testing::HasSubstr;

constexpr char kPath[] = "CAL.json";

std::string TextOf(CalibrationFile file) {
  test::TestStorage storage;
  EXPECT_TRUE(WriteCalibrationFile(storage, kPath, file));
  const std::vector<std::byte>& bytes = storage.files[kPath];
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The file with something changed in its JSON, by somebody who knows how its hash is made.
std::string Forged(const std::function<void(Json&)>& change) {
  Json json = Json::parse(TextOf(test::MakeCalibrationFile()));
  json.erase("hash");
  change(json);
  const std::string content = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  json["hash"] = "sha256:" + Sha256Hex(std::as_bytes(std::span(content)));
  return json.dump();
}

std::string WhyRefused(const std::string& text) {
  const auto read = ParseCalibrationFile(text, kPath);
  if (read) return "it was read";
  EXPECT_EQ(read.error().attempted, "read the calibration CAL.json");
  EXPECT_FALSE(read.error().advice.empty());
  EXPECT_EQ(read.error().Text().find('\n'), std::string::npos);
  return read.error().seen;
}

TEST(CalibrationFile, GivesBackEveryBit) {
  test::TestStorage storage;
  CalibrationFile file = test::MakeCalibrationFile();
  ASSERT_TRUE(WriteCalibrationFile(storage, kPath, file));
  EXPECT_EQ(file.calibration.certificate.size(), std::string("sha256:").size() + 64);
  const auto read = ReadCalibrationFile(storage, kPath);
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(test::SameFile(*read, file));
}

TEST(CalibrationFile, OfAnIdealRingIsReadToo) {
  CalibrationFile plain;
  plain.calibration = RingCalibration::Ideal(600.0, 3);
  test::TestStorage storage;
  ASSERT_TRUE(WriteCalibrationFile(storage, kPath, plain));
  const auto read = ReadCalibrationFile(storage, kPath);
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_TRUE(test::SameFile(*read, plain));
}

TEST(CalibrationFile, HasTheSameHashHoweverOftenItIsWritten) {
  test::TestStorage storage;
  CalibrationFile file = test::MakeCalibrationFile();
  ASSERT_TRUE(WriteCalibrationFile(storage, kPath, file));
  const std::string hash = file.calibration.certificate;
  ASSERT_TRUE(WriteCalibrationFile(storage, "b", file)) << "the certificate is no part of what it is the hash of";
  EXPECT_EQ(file.calibration.certificate, hash);
  auto read = ReadCalibrationFile(storage, kPath);
  ASSERT_TRUE(read);
  ASSERT_TRUE(WriteCalibrationFile(storage, "c", *read));
  EXPECT_EQ(storage.files["c"], storage.files[kPath]);
  file.calibration.sensors[0].range_offset_mm += 1e-12;
  ASSERT_TRUE(WriteCalibrationFile(storage, "d", file));
  EXPECT_NE(file.calibration.certificate, hash);
}

TEST(CalibrationFile, IsReadAfterItsSpacesWereChangedBecauseNothingElseWas) {
  const std::string text = TextOf(test::MakeCalibrationFile());
  EXPECT_EQ(WhyRefused(Json::parse(text).dump(4)), "it was read");
}

TEST(CalibrationFile, ThatWasEditedIsRefused) {
  for (const char* key : {"technician", "valid_until_ns", "passed", "ambient_c"}) {
    Json json = Json::parse(TextOf(test::MakeCalibrationFile()));
    json[key] = json[key].is_string() ? Json("x") : json[key].is_boolean() ? Json(false) : Json(1);
    EXPECT_EQ(WhyRefused(json.dump()), "its hash does not fit its content: it was edited or damaged") << key;
  }
  Json json = Json::parse(TextOf(test::MakeCalibrationFile()));
  json["calibration"]["range_offset_mm"][0] = 0.0;
  EXPECT_EQ(WhyRefused(json.dump()), "its hash does not fit its content: it was edited or damaged");
  json.erase("hash");
  EXPECT_EQ(WhyRefused(json.dump()), "its hash does not fit its content: it was edited or damaged");
}

TEST(CalibrationFile, WithAnyByteChangedIsRefusedOrMeansTheSame) {
  const std::string text = TextOf(test::MakeCalibrationFile());
  const auto whole = ParseCalibrationFile(text, kPath);
  ASSERT_TRUE(whole);
  for (std::size_t at = 0; at < text.size(); at += 7) {
    std::string damaged = text;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    const auto read = ParseCalibrationFile(damaged, kPath);
    EXPECT_TRUE(!read || test::SameFile(*read, *whole)) << at;
  }
}

TEST(CalibrationFile, CutAnywhereIsRefused) {
  const std::string text = TextOf(test::MakeCalibrationFile());
  for (std::size_t size = 0; size < text.size() - 2; size += 101) {
    EXPECT_EQ(WhyRefused(text.substr(0, size)), "it is not a calibration file of annulus") << size;
  }
}

TEST(CalibrationFile, OfAnotherFormatOrVersionIsRefused) {
  EXPECT_EQ(WhyRefused(Forged([](Json& json) { json["format"] = "annulus-model"; })),
            "it is not a calibration file of annulus");
  EXPECT_EQ(WhyRefused("[]"), "it is not a calibration file of annulus");
  EXPECT_EQ(WhyRefused("CAL"), "it is not a calibration file of annulus");
  EXPECT_EQ(WhyRefused(Forged([](Json& json) { json["version"] = 2; })), "its version is not 1");
  EXPECT_EQ(WhyRefused(std::string(100'000, '[')), "it is not a calibration file of annulus");
  EXPECT_EQ(WhyRefused(Forged([](Json& json) { json["more"] = Json::parse(R"({"a":[[[[[[[1]]]]]]]})"); })),
            "it is not a calibration file of annulus");
}

TEST(CalibrationFile, PassesOverKeysItDoesNotKnow) {
  EXPECT_EQ(WhyRefused(Forged([](Json& json) { json["later"] = 1; })), "it was read");
}

TEST(CalibrationFile, WithANumberThatCannotBeIsRefusedAndTheKeyIsNamed) {
  const auto set = [](const char* key, const Json& value) {
    return WhyRefused(Forged([&](Json& json) { json[key] = value; }));
  };
  EXPECT_EQ(set("wall_ns", 1e300), "'wall_ns' is missing or wrong");
  EXPECT_EQ(set("valid_until_ns", std::uint64_t{1} << 63U), "'valid_until_ns' is missing or wrong");
  EXPECT_EQ(set("ambient_c", nullptr), "'ambient_c' is missing or wrong");
  EXPECT_EQ(set("ambient_c", 1e10), "'ambient_c' is missing or wrong");
  EXPECT_EQ(set("passed", 1), "'passed' is missing or wrong");
  EXPECT_EQ(set("technician", 1), "'technician' is missing or wrong");
  EXPECT_EQ(set("boards", Json::object()), "'boards' is missing or wrong");
  EXPECT_EQ(set("boards", {1}), "'boards' is missing or wrong");
  EXPECT_EQ(set("recordings", {1}), "'recordings' is missing or wrong");
  EXPECT_EQ(set("sensor_covariance", {{1.0}}), "'sensor_covariance' is missing or wrong");
  EXPECT_EQ(set("calibration", 1), "'calibration' is missing or wrong");
  const auto within = [](const char* list, const char* key, const Json& value) {
    return WhyRefused(Forged([&](Json& json) { json[list][0][key] = value; }));
  };
  EXPECT_EQ(within("boards", "first_sensor", 65'536), "'first_sensor' is missing or wrong");
  EXPECT_EQ(within("boards", "serial", -1), "'serial' is missing or wrong");
  EXPECT_EQ(within("boards", "serial", 1.5), "'serial' is missing or wrong");
  EXPECT_EQ(within("targets", "kind", "cone"), "'kind' is missing or wrong");
  EXPECT_EQ(within("targets", "radius_mm", -1.0), "'radius_mm' is missing or wrong");
  EXPECT_EQ(within("targets", "edges_mm", {"x"}), "'edges_mm' is missing or wrong");
  EXPECT_EQ(within("history", "sensor_shift_mm", "0"), "'sensor_shift_mm' is missing or wrong");
}

TEST(CalibrationFile, WithACalibrationThatCannotBeIsRefusedAndTheKeyIsNamed) {
  const auto within = [](const char* key, const Json& value) {
    return WhyRefused(Forged([&](Json& json) { json["calibration"][key] = value; }));
  };
  EXPECT_EQ(within("range_scale", {1, 1, 1, 1, 1, 1, 1, 0}), "'range_scale' is missing or wrong");
  EXPECT_EQ(within("radius_mm", {1, 1, 1, 1, 1, 1, 1, -1}), "'radius_mm' is missing or wrong");
  EXPECT_EQ(within("aim_lateral_rad", {0, 0}), "'aim_lateral_rad' is missing or wrong");
  EXPECT_EQ(within("theta_rad", Json::array()), "'radius_mm' is missing or wrong");
  EXPECT_EQ(within("pose", {{"x_mm", 1.0}}), "'y_mm' is missing or wrong");
  EXPECT_EQ(WhyRefused(Forged([](Json& json) { json["sensor_covariance"].erase(0); })),
            "it has not one covariance per sensor");
  EXPECT_EQ(WhyRefused(Forged([](Json& json) { json["sensor_covariance"][0][0] = -1.0; })),
            "'sensor_covariance' is missing or wrong");
}

TEST(CalibrationFile, ThatIsNotThereIsNamed) {
  test::TestStorage storage;
  const auto read = ReadCalibrationFile(storage, "nowhere.json");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().Text(), HasSubstr("nowhere.json"));
}

Status Checked(const std::function<void(CalibrationFile&, std::vector<RecordedBoard>&)>& change,
               std::int64_t later_ns = 0) {
  CalibrationFile file = test::MakeCalibrationFile();
  std::vector<RecordedBoard> boards = file.boards;
  change(file, boards);
  return CheckCalibrationFor(file, boards, file.wall_ns + later_ns);
}
void Nothing(CalibrationFile&, std::vector<RecordedBoard>&) {}

TEST(CheckCalibrationFor, TakesTheBoardsThatWereCalibratedInAnyOrderAndWithNewFirmware) {
  EXPECT_TRUE(Checked(Nothing));
  EXPECT_TRUE(Checked([](CalibrationFile&, std::vector<RecordedBoard>& boards) {
    std::swap(boards[0], boards[1]);
    boards[0].firmware_version = "9.0.0";
  }));
}

TEST(CheckCalibrationFor, NamesTheBoardThatIsAnother) {
  const Status status = Checked([](CalibrationFile&, std::vector<RecordedBoard>& boards) { boards[0].serial = 7; });
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().seen, "board 7 (sensors 0 to 3) is not the one that was calibrated there (1001)");
  EXPECT_THAT(status.error().advice, HasSubstr("calibrate it alone"));
}

TEST(CheckCalibrationFor, NamesBoardsThatWereExchanged) {
  const Status status = Checked(
      [](CalibrationFile&, std::vector<RecordedBoard>& boards) { std::swap(boards[0].serial, boards[1].serial); });
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().seen, HasSubstr("board 4294967295 (sensors 0 to 3)"));
}

TEST(CheckCalibrationFor, RefusesARingOfAnotherNumberOfBoards) {
  Status status = Checked([](CalibrationFile&, std::vector<RecordedBoard>& boards) { boards.pop_back(); });
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().seen, "it is of a ring of 2 boards, this one has 1");
  status = Checked([](CalibrationFile&, std::vector<RecordedBoard>& boards) { boards.push_back({9, 8, 4, 2, ""}); });
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().seen, "sensors 8 to 11 are not in it: it is of another ring");
}

TEST(CheckCalibrationFor, RefusesOneThatHasExpired) {
  constexpr std::int64_t kDayNs = 86'400'000'000'000;
  EXPECT_TRUE(Checked(Nothing, kDayNs)) << "to the last nanosecond";
  const Status status = Checked(Nothing, kDayNs + 1);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().seen, "it was valid until 2026-05-29T20:26:40Z");
  EXPECT_EQ(status.error().advice, "calibrate the ring again");
}

TEST(CheckCalibrationFor, RefusesOneThatDidNotKeepItsLimits) {
  const Status status = Checked([](CalibrationFile& file, std::vector<RecordedBoard>&) { file.passed = false; });
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().seen, HasSubstr("limits"));
}

TEST(RingSerialOf, IsTheSameForTheSameBoardsInTheirPlaces) {
  const std::vector<RecordedBoard> boards = test::MakeCalibrationFile().boards;
  EXPECT_EQ(RingSerialOf(boards), RingSerialOf({boards[1], boards[0]}));
  // python3: sha256(b'1001;4294967295;').hexdigest()[:8]
  EXPECT_EQ(RingSerialOf(boards), "ring-a76e539f");
  std::vector<RecordedBoard> exchanged = boards;
  std::swap(exchanged[0].serial, exchanged[1].serial);
  EXPECT_NE(RingSerialOf(exchanged), RingSerialOf(boards));
}

TEST(UtcText, IsTheDateAndTimeOfDay) {
  EXPECT_EQ(UtcText(0), "1970-01-01T00:00:00Z");
  EXPECT_EQ(UtcText(946'684'799'999'999'999), "1999-12-31T23:59:59Z");
  EXPECT_EQ(UtcText(951'782'400'000'000'000), "2000-02-29T00:00:00Z");
  EXPECT_EQ(UtcText(-1), "1969-12-31T23:59:59Z");
}

}  // namespace
}  // namespace annulus
