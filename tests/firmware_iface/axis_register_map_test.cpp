#include "firmware_iface/axis_register_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "tests/support/folders.h"

namespace annulus {
namespace {

// CiA 402 (IEC 61800-7-201), coding of the state in the status word; x bits set here to 1.
TEST(AxisRegisterMap, DecodesTheStatesOfCia402) {
  EXPECT_EQ(DriveStateOf(0b0000'0000'0010'0000), DriveState::kNotReady);
  EXPECT_EQ(DriveStateOf(0b0000'0000'0110'0000), DriveState::kSwitchOnDisabled);
  EXPECT_EQ(DriveStateOf(0b1111'1111'1011'0001), DriveState::kReadyToSwitchOn);
  EXPECT_EQ(DriveStateOf(0b0000'0000'0010'0011), DriveState::kSwitchedOn);
  EXPECT_EQ(DriveStateOf(0b0000'0010'0011'0111), DriveState::kOperationEnabled);
  EXPECT_EQ(DriveStateOf(0b0000'0000'0000'0111), DriveState::kQuickStopActive);
  EXPECT_EQ(DriveStateOf(0b0000'0000'0010'1111), DriveState::kFaultReaction);
  EXPECT_EQ(DriveStateOf(0b0000'0000'0000'1000), DriveState::kFault);
  EXPECT_EQ(DriveStateOf(0b0000'0000'0110'0001), DriveState::kUnknown);
}

TEST(AxisRegisterMap, WritesTheStatesAsItReadsThem) {
  for (int state = 0; state < static_cast<int>(DriveState::kUnknown); ++state) {
    EXPECT_EQ(DriveStateOf(StatusBitsOf(static_cast<DriveState>(state))), static_cast<DriveState>(state));
  }
}

TEST(AxisRegisterMap, SpansTheBlocksOfTheWireProtocol) {
  const AxisRegisterMap map;
  EXPECT_EQ(map.CommandBlock().address, 0x0000);
  EXPECT_EQ(map.CommandBlock().count, 9);
  EXPECT_EQ(map.StatusBlock().address, 0x0100);
  EXPECT_EQ(map.StatusBlock().count, 8);
  EXPECT_EQ(map.IdentityBlock().address, 0x0100);
  EXPECT_EQ(map.IdentityBlock().count, 24);
  EXPECT_TRUE(CheckRegisterMap(map));
}

TEST(AxisRegisterMap, RefusesBlocksThatNoTransactionCarries) {
  AxisRegisterMap wide_command;
  wide_command.control_word = 200;
  EXPECT_FALSE(CheckRegisterMap(wide_command));
  AxisRegisterMap wide_status;
  wide_status.position = 0x0100 + 124;  // its low word is register 126 of the block
  EXPECT_FALSE(CheckRegisterMap(wide_status));
  AxisRegisterMap whole;
  whole.echo = 0;
  whole.heartbeat_timeout = 0xFFFF;
  EXPECT_FALSE(CheckRegisterMap(whole));
}

TEST(AxisRegisterMap, RefusesWhatOverlapsIsMissingOrHasNoScale) {
  const auto refused = [](const AxisRegisterMap& map) {
    const Status checked = CheckRegisterMap(map);
    return checked ? std::string("accepted") : checked.error().seen;
  };
  AxisRegisterMap map;
  map.position = map.fault_code;
  EXPECT_THAT(refused(map), testing::HasSubstr("fault_code and position share"));
  map = {};
  map.target_position = static_cast<std::uint16_t>(map.profile_speed - 3);
  EXPECT_THAT(refused(map), testing::HasSubstr("mode and target_position share"));
  map = {};
  map.echo = kNoRegister;
  EXPECT_THAT(refused(map), testing::HasSubstr("echo has no register"));
  map = {};
  map.max_speed = 0xFFFE;  // its second half would be FFFFh
  EXPECT_THAT(refused(map), testing::HasSubstr("max_speed ends beyond"));
  map = {};
  map.units_per_mm = 0.0;
  EXPECT_THAT(refused(map), testing::HasSubstr("units_per_mm is not above 0"));
  map = {};
  map.declared_heartbeat_ms = std::nan("");
  EXPECT_THAT(refused(map), testing::HasSubstr("declared_heartbeat_ms is no number"));
  map = {};
  map.counter_registers = 2;
  EXPECT_THAT(refused(map), testing::HasSubstr("control_word lies in the counter's second register"));
  map = {};
  map.flags = map.drive_time = kNoRegister;
  EXPECT_EQ(refused(map), "accepted");
}

TEST(AxisRegisterMap, NamesEveryRegisterOnce) {
  std::set<std::string> names;
  std::set<std::uint16_t> addresses;
  const AxisRegisterMap map;
  for (const AxisRegisterField& field : AxisRegisterFields()) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
    EXPECT_TRUE(addresses.insert(map.*field.address).second) << field.name;
  }
  EXPECT_EQ(names.size(), 22U);
}

/// The map of an example file: `name = number` or `name = "none"`, `#` begins a remark.
AxisRegisterMap Example(const std::string& path) {
  AxisRegisterMap map;
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  std::set<std::string> told;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string name;
    std::string equals;
    std::string value;
    if (!(words >> name >> equals >> value) || name == "word_order") continue;
    bool known = false;
    for (const AxisRegisterField& field : AxisRegisterFields()) {
      if (name != field.name) continue;
      known = told.insert(name).second;
      map.*field.address = value == "\"none\"" ? kNoRegister : static_cast<std::uint16_t>(std::stoi(value));
    }
    for (const AxisScaleField& field : AxisScaleFields()) {
      if (name != field.name) continue;
      known = true;
      map.*field.value = std::stod(value);
    }
    EXPECT_TRUE(known) << name;
  }
  EXPECT_EQ(told.size(), AxisRegisterFields().size());
  return map;
}

TEST(AxisRegisterMap, TakesTheExampleOfTheDocumentation) {
  const AxisRegisterMap map = Example(test::SourceFolder() + "/docs/examples/axis-nanotec-pd4e.toml");
  const Status checked = CheckRegisterMap(map);
  ASSERT_TRUE(checked) << checked.error().Text();
  EXPECT_EQ(map.CommandBlock().address, 6001);
  EXPECT_EQ(map.CommandBlock().count, 9);
  EXPECT_EQ(map.StatusBlock().address, 5001);
  EXPECT_EQ(map.StatusBlock().count, 5);
  EXPECT_EQ(map.IdentityBlock().count, 13);
  EXPECT_EQ(map.declared_heartbeat_ms, 0.0);  // refused until somebody has measured it
}

TEST(AxisRegisterMap, SaysWhatAFaultMeans) {
  EXPECT_THAT(AxisFaultText(0x8611), testing::HasSubstr("following error"));
  EXPECT_THAT(AxisFaultText(0x8611), testing::StartsWith("fault 8611h"));
  for (std::uint16_t code = 0x5441; code <= 0x5443; ++code) {
    EXPECT_THAT(AxisFaultText(code), testing::HasSubstr("safety chain"));
  }
  EXPECT_THAT(AxisFaultText(0xABCD), testing::HasSubstr("drive's manual"));
}

}  // namespace
}  // namespace annulus
