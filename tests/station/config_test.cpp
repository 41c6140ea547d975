#include "station/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/folders.h"

namespace annulus {
namespace {

using testing::HasSubstr;

TEST(Config, TheBuiltInOneIsASimulatedBoothWithABody) {
  PosixStorage storage;
  const auto config = ReadConfig(storage, "sim");
  ASSERT_TRUE(config) << config.error().Text();
  EXPECT_EQ(config->ring.bus, RingBus::kSimulated);
  EXPECT_TRUE(config->axis.simulated());
  EXPECT_TRUE(config->interlock.simulated);
  EXPECT_EQ(config->sim.subject, "body");
}

TEST(Config, ReadsEveryKeyOfItsSections) {
  const auto config = ParseConfig(R"(
[station]
id = "booth-3"
language = "ja"
units = "mm"
[ring]
bus = "usb"
radius_mm = 610.5
boards = { 1001 = 0, 1002 = 15 }
[axis]
link = "/dev/ttyUSB0"
[profile.body]
z_top_mm = 1900
pitch_mm = 4
[profile.bust]
z_top_mm = "auto"
z_bottom_mm = 1200
pitch_mm = 2
speed_mm_s = 60
sweeps = 2
level_rate_hz = 30
[calibration]
file = "cal.json"
[sim]
seed = 42
subject = "head"
noise_mm = 0.25
dropout_rate = 0.02
outlier_rate = 0
sway = 1
breathing = 0.01
hair = true
spectacles = true
dark_patches = true
cap = true
loose_clothing = true
step_aside_s = 8
leave_s = 12.5
raise_arm_s = 3
faults = "plans/estop.json"
)",
                                  "test.toml");
  ASSERT_TRUE(config) << config.error().Text();
  EXPECT_EQ(config->station_id, "booth-3");
  EXPECT_EQ(config->ring.bus, RingBus::kUsb);
  EXPECT_EQ(config->ring.radius_mm, 610.5);
  EXPECT_EQ(config->ring.boards, (std::map<std::uint32_t, std::uint16_t>{{1001, 0}, {1002, 15}}));
  EXPECT_EQ(config->axis.LinkText(), "/dev/ttyUSB0");
  EXPECT_EQ(config->profiles.at("body").z_top_mm, 1900.0);
  EXPECT_FALSE(config->profiles.at("body").find_top);
  EXPECT_TRUE(config->profiles.at("bust").find_top);
  EXPECT_FALSE(config->profiles.at("bust").z_top_mm.has_value());
  EXPECT_EQ(config->profiles.at("bust").sweeps, 2U);
  EXPECT_EQ(config->calibration.file, "cal.json");
  EXPECT_EQ(config->sim.seed, 42U);
  EXPECT_EQ(config->sim.subject, "head");
  EXPECT_EQ(config->sim.noise_mm, 0.25);
  EXPECT_EQ(config->sim.faults, "plans/estop.json");
  EXPECT_TRUE(config->sim.hair && config->sim.spectacles && config->sim.dark_patches);
  EXPECT_TRUE(config->sim.cap && config->sim.loose_clothing);
  EXPECT_EQ(config->sim.step_aside_s, 8.0);
  EXPECT_EQ(config->sim.leave_s, 12.5);
  EXPECT_EQ(config->sim.raise_arm_s, 3.0);
}

TEST(Config, ReadsATargetAndTheRingsErrors) {
  const auto config = ParseConfig(R"(
[sim]
ring_errors = 1
ring_seed = 17
ring_tilt_deg = 0.5
ring_bend_mm = 0.3
ring_position_scale = 1.0004
ring_range_mm_per_c = 0.01
ring_temperature_c = 24
[sim.target]
kind = "step"
radius_mm = 75
true_radius_mm = 75.1
height_mm = 900
step_mm = 6
edges_mm = [200, 500]
x_mm = 80
y_mm = -20
tilt_x_deg = 5
tilt_y_deg = -90e-1
turn_deg = 60
out_of_round_mm = 0.05
taper_mm_per_m = 0.2
seed = 4
moved_at_s = 20
moved_y_mm = 1.5
)",
                                  "test.toml");
  ASSERT_TRUE(config) << config.error().Text();
  const SimRing ring{1.0, 17, RadiansFromDegrees(0.5), 0.3, 1.0004, 0.01, 24.0};
  EXPECT_EQ(config->sim.ring, ring);
  ASSERT_TRUE(config->sim.target);
  const SimTarget& target = *config->sim.target;
  EXPECT_EQ(target.target.kind, CalibrationTarget::Kind::kStep);
  EXPECT_EQ(target.target.radius_mm, 75.0);
  EXPECT_EQ(target.truth.radius_mm, 75.1);
  EXPECT_EQ(target.target.height_mm, 900.0);
  EXPECT_EQ(target.target.edges_mm, (std::vector<double>{200.0, 500.0}));
  EXPECT_EQ(target.placement.x_mm, 80.0);
  EXPECT_EQ(target.placement.y_mm, -20.0);
  EXPECT_DOUBLE_EQ(target.placement.tilt_x, RadiansFromDegrees(5.0));
  EXPECT_DOUBLE_EQ(target.placement.tilt_y, RadiansFromDegrees(-9.0));
  EXPECT_DOUBLE_EQ(target.placement.turn_rad, RadiansFromDegrees(60.0));
  EXPECT_EQ(target.out_of_round_mm, 0.05);
  EXPECT_DOUBLE_EQ(target.truth.taper, 2e-4);
  EXPECT_EQ(target.seed, 4U);
  ASSERT_TRUE(target.moved);
  EXPECT_EQ(target.moved->at_s, 20.0);
  EXPECT_EQ(target.moved->y_mm, 1.5);
}

/// The message of a configuration that must be refused.
std::string RefusalOf(const std::string& toml) {
  const auto config = ParseConfig(toml, "test.toml");
  return config ? "accepted" : config.error().Text();
}

TEST(Config, AnUnknownKeyIsRefusedWithItsLineAndTheKnownOnes) {
  const std::string text = RefusalOf("[station]\nid = \"a\"\n[ring]\nradius = 600\n");
  EXPECT_THAT(text, HasSubstr("test.toml"));
  EXPECT_THAT(text, HasSubstr("line 4"));
  EXPECT_THAT(text, HasSubstr("'radius'"));
  EXPECT_THAT(text, HasSubstr("radius_mm"));
}

TEST(Config, ATargetThatCannotBeIsRefusedWithItsReason) {
  const auto target = [](const std::string& keys) { return RefusalOf("[sim]\n[sim.target]\n" + keys + "\n"); };
  EXPECT_THAT(target("kind = \"cone\""), HasSubstr("\"cylinder\""));
  EXPECT_THAT(target("kind = \"cylinder\""), HasSubstr("it has no radius"));
  EXPECT_THAT(target("radius_mm = 50\nout_of_round_mm = 20"), HasSubstr("not convex"));
  EXPECT_THAT(target("kind = \"step\"\nradius_mm = 50\nstep_mm = 5\nedges_mm = [300, 200]"), HasSubstr("ascend"));
  EXPECT_THAT(target("kind = \"sphere\"\nradius_mm = 4"), HasSubstr("rod"));
  EXPECT_THAT(target("kind = \"plane\"\nout_of_round_mm = 0.1"), HasSubstr("board"));
  EXPECT_THAT(target("kind = \"plane\"\nbredth_mm = 3"), HasSubstr("'bredth_mm'"));
}

TEST(Config, AnUnknownSectionIsRefusedWithItsLine) {
  EXPECT_THAT(RefusalOf("\n\n[rings]\nradius_mm = 600\n"), HasSubstr("line 3"));
}

TEST(Config, AValueOfTheWrongKindIsRefusedWithItsLine) {
  for (const char* line : {"radius_mm = \"wide\"", "radius_mm = 1e9", "radius_mm = nan", "radius_mm = true", "bus = 5",
                           "bus = \"serial\"", "boards = 7", "boards = { left = 1 }"}) {
    EXPECT_THAT(RefusalOf("[ring]\n" + std::string(line) + "\n"), HasSubstr("line 2")) << line;
  }
  EXPECT_THAT(RefusalOf("ring = 5\n"), HasSubstr("line 1"));
  EXPECT_THAT(RefusalOf("[sim]\nseed = -1\n"), HasSubstr("line 2"));
  EXPECT_THAT(RefusalOf("[profile.body]\nsweeps = 1.5\n"), HasSubstr("line 2"));
}

TEST(Config, WhatIsNoTomlIsRefusedWithItsLine) {
  EXPECT_THAT(RefusalOf("[station]\nid = \"a\"\nid = \"b\"\n"), HasSubstr("line 3"));
  EXPECT_THAT(RefusalOf("[station\n"), HasSubstr("line 1"));
}

TEST(Config, ReadsWhereTheDevicesAre) {
  const auto config = ParseConfig(R"(
[ring]
bus = "can"
can = ["can0", "can1"]
[axis]
link = "/dev/serial/by-id/usb-x"
unit = 7
baud = 57600
parity = "none"
stop_bits = 2
[interlock]
chip = "booth-io"
door = "X4-3"
call = { line = "X4-8", bias = "pull-up", active_low = true }
)",
                                  "test.toml");
  ASSERT_TRUE(config) << config.error().Text();
  EXPECT_EQ(config->ring.bus, RingBus::kCan);
  EXPECT_EQ(config->ring.can_interfaces, (std::vector<std::string>{"can0", "can1"}));
  const auto* serial = std::get_if<ModbusRtuOptions>(&config->axis.link);
  ASSERT_NE(serial, nullptr);
  EXPECT_EQ(serial->device, "/dev/serial/by-id/usb-x");
  EXPECT_EQ(serial->unit, 7);
  EXPECT_EQ(serial->baud, 57600);
  EXPECT_EQ(serial->parity, 'N');
  EXPECT_EQ(serial->stop_bits, 2);
  EXPECT_FALSE(config->interlock.simulated);
  EXPECT_EQ(config->interlock.wiring.chip, "booth-io");
  EXPECT_EQ(config->interlock.wiring.inputs.at(InterlockInput::kDoor).name, "X4-3");
  EXPECT_EQ(config->interlock.wiring.inputs.at(InterlockInput::kEstopA).name, "estop_a");
  const GpioLineSpec& call = config->interlock.wiring.inputs.at(InterlockInput::kCall);
  EXPECT_EQ(call.name, "X4-8");
  EXPECT_EQ(call.bias, GpioBias::kPullUp);
  EXPECT_TRUE(call.active_low);
}

TEST(Config, ReadsWhereTheReferenceSensorsStand) {
  const auto config = ParseConfig(R"(
[ring]
radius_mm = 610
reference = { board = 1013, sensors = [
  { channel = 4, theta_deg = 90, distance_mm = 900, height_mm = 950 },
  { channel = 0, theta_deg = -90, distance_mm = 1000, height_mm = 1500, aim_deg = 2 } ] }
)",
                                  "test.toml");
  ASSERT_TRUE(config) << config.error().Text();
  ASSERT_TRUE(config->ring.reference);
  EXPECT_EQ(config->ring.reference->board, 1013U);
  ASSERT_EQ(config->ring.reference->sensors.size(), 2U);
  const ReferenceSensor front{4, kPi / 2.0, 900.0, 950.0, 0.0};
  EXPECT_EQ(config->ring.reference->sensors[0], front);
  EXPECT_NEAR(config->ring.reference->sensors[1].aim, 0.0349065850, 1e-9);
  EXPECT_EQ(ReferenceBoardOf(config->ring)->channels, (std::vector<std::uint8_t>{4, 0}));
  EXPECT_FALSE(config->sim.reference);
}

TEST(Config, TheSimulatedReferenceBoardHasFrontAndSideAtTwoHeightsUnlessTold) {
  const auto standard = ParseConfig("[sim]\nreference = true\n", "test.toml");
  ASSERT_TRUE(standard) << standard.error().Text();
  EXPECT_EQ(standard->ring.reference->sensors, StandardReferenceSensors());
  const auto own = ParseConfig(
      "[sim]\nreference = true\n[ring]\nreference = { board = 1013, sensors = [ { distance_mm = 800, height_mm = 1 } ] "
      "}\n",
      "test.toml");
  ASSERT_TRUE(own) << own.error().Text();
  EXPECT_EQ(own->ring.reference->sensors.size(), 1U);
  EXPECT_FALSE(ParseConfig("", "test.toml")->ring.reference);
}

TEST(Config, RefusesReferenceSensorsThatCannotBe) {
  const auto refused = [](const std::string& reference) {
    return RefusalOf("[ring]\nboards = { 1001 = 0 }\nreference = " + reference + "\n");
  };
  const std::string sensor = "{ channel = 0, distance_mm = 900, height_mm = 950 }";
  EXPECT_EQ(refused("{ board = 1013, sensors = [" + sensor + "] }"), "accepted");
  EXPECT_THAT(refused("5"), HasSubstr("line 3"));
  EXPECT_THAT(refused("{ board = 1013 }"), HasSubstr("sensors"));
  EXPECT_THAT(refused("{ sensors = [" + sensor + "] }"), HasSubstr("board"));
  EXPECT_THAT(refused("{ board = 1013, sensors = [] }"), HasSubstr("at least one"));
  EXPECT_THAT(refused("{ board = 1013, sensors = [ 5 ] }"), HasSubstr("line 3"));
  EXPECT_THAT(refused("{ board = 1013, sensors = [" + sensor + "," + sensor + "] }"), HasSubstr("different channels"));
  EXPECT_THAT(refused("{ board = 1001, sensors = [" + sensor + "] }"), HasSubstr("not one of [ring] boards"));
  EXPECT_THAT(refused("{ board = 1013, sensors = [ { channel = 15, distance_mm = 900, height_mm = 950 } ] }"),
              HasSubstr("channel"));
  EXPECT_THAT(refused("{ board = 1013, sensors = [ { distance_mm = 500, height_mm = 950 } ] }"),
              HasSubstr("beyond the ring"));
  EXPECT_THAT(refused("{ board = 1013, sensors = [ { height_mm = 950 } ] }"), HasSubstr("distance"));
}

TEST(Config, ReadsAnAddressWithColonsOfItsOwn) {
  const auto config = ParseConfig("[axis]\nlink = \"tcp:::1:5020\"\n", "test.toml");
  ASSERT_TRUE(config) << config.error().Text();
  const auto* tcp = std::get_if<ModbusTcpOptions>(&config->axis.link);
  ASSERT_NE(tcp, nullptr);
  EXPECT_EQ(tcp->host, "::1");
  EXPECT_EQ(tcp->port, 5020);
}

TEST(Config, ReadsTheRegisterMapOfAnotherMake) {
  PosixStorage storage;
  const auto config = ReadConfig(storage, test::SourceFolder() + "/docs/examples/axis-nanotec-pd4e.toml");
  ASSERT_TRUE(config) << config.error().Text();
  const AxisRegisterMap& map = config->axis.register_map;
  EXPECT_EQ(map.control_word, 6002);
  EXPECT_EQ(map.position, 5004);
  EXPECT_EQ(map.drive_time, kNoRegister);
  EXPECT_EQ(map.word_order, WordOrder::kHighFirst);
}

TEST(Config, RefusesRegisterMapsThatMakeNoSense) {
  const auto refused = [](const std::string& line) {
    const auto config = ParseConfig("[axis.register_map]\n" + line + "\n", "test.toml");
    EXPECT_FALSE(config) << line;
    return config ? std::string() : config.error().Text();
  };
  EXPECT_THAT(refused("control_word = 0"), HasSubstr("counter and control_word share a register"));
  EXPECT_THAT(refused("control_word = \"none\""), HasSubstr("control_word is not a whole number"));
  EXPECT_THAT(refused("units_per_mm = 0"), HasSubstr("units_per_mm"));
  EXPECT_THAT(refused("word_order = \"middle\""), HasSubstr("word_order"));
  EXPECT_THAT(refused("positoin = 3"), HasSubstr("unknown key 'positoin'"));
}

}  // namespace
}  // namespace annulus
