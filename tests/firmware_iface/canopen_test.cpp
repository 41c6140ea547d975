#include "firmware_iface/canopen.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "firmware_iface/can_timing.h"
#include "firmware_iface/sdo.h"
#include "firmware_iface/socket_can_codec.h"
#include "tests/firmware_iface/can_frame_text.h"

namespace annulus {
namespace {

using testing::HasSubstr;

std::vector<std::byte> Bytes(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// The bytes of the frames below are worked out by hand from the tables of CiA 301 (7.2.4 SDO, 7.2.5 SYNC, 7.2.7 EMCY,
// 7.2.8 NMT and heartbeat).

TEST(Canopen, WritesTheFramesOfTheStandard) {
  EXPECT_EQ(TextOf(EncodeNmt({NmtCommand::kStart, 0})), "000#0100");
  EXPECT_EQ(TextOf(EncodeNmt({NmtCommand::kResetCommunication, 12})), "000#820C");
  EXPECT_EQ(TextOf(EncodeSync(17)), "080#11");
  EXPECT_EQ(TextOf(EncodeHeartbeat({5, NmtState::kBootUp})), "705#00");
  EXPECT_EQ(TextOf(EncodeHeartbeat({127, NmtState::kPreOperational})), "77F#7F");
  EXPECT_EQ(TextOf(EncodeEmergency({9, 0x8150, 1, 1009, 0})), "089#508101F103000000");
}

TEST(Canopen, ReadsWhatItWrites) {
  EXPECT_EQ(DecodeNmt(FrameOf("000#8105")), (NmtOrder{NmtCommand::kResetNode, 5}));
  EXPECT_EQ(DecodeSync(FrameOf("080#F0")), 240);
  EXPECT_EQ(DecodeHeartbeat(FrameOf("701#05")), (Heartbeat{1, NmtState::kOperational}));
  EXPECT_EQ(DecodeEmergency(FrameOf("089#508101F103000007")), (Emergency{9, 0x8150, 1, 1009, 7}));
}

TEST(Canopen, RefusesWhatIsNotExactlyOneOfItsFrames) {
  EXPECT_FALSE(DecodeNmt(FrameOf("000#01")));
  EXPECT_FALSE(DecodeNmt(FrameOf("000#0180")));
  EXPECT_FALSE(DecodeNmt(FrameOf("000#0301")));
  EXPECT_FALSE(DecodeSync(FrameOf("080#")));
  EXPECT_FALSE(DecodeSync(FrameOf("080#00")));
  EXPECT_FALSE(DecodeSync(FrameOf("080#F1")));
  EXPECT_FALSE(DecodeHeartbeat(FrameOf("700#05")));
  EXPECT_FALSE(DecodeHeartbeat(FrameOf("705#06")));
  EXPECT_FALSE(DecodeHeartbeat(FrameOf("705#0500")));
  EXPECT_FALSE(DecodeEmergency(FrameOf("080#0000000000000000")));
  CanFrame remote = FrameOf("705#05");
  remote.remote = true;
  EXPECT_FALSE(DecodeHeartbeat(remote));
  CanFrame extended = FrameOf("705#05");
  extended.extended = true;
  EXPECT_FALSE(DecodeHeartbeat(extended));
}

TEST(Canopen, HasATextForEveryEmergencyCode) {
  EXPECT_EQ(EmergencyText(0x8130), "8130h: it misses a heartbeat that it watches");
  EXPECT_EQ(EmergencyText(0x4201), "4201h: temperature of the board");
  EXPECT_EQ(EmergencyText(0x8199), "8199h: communication");
  EXPECT_EQ(EmergencyText(0x5FFF), "5FFFh: hardware of the board");
  EXPECT_EQ(EmergencyText(0xFFFF), "FFFFh: device specific");
  EXPECT_EQ(EmergencyText(0xB000), "B000h: unknown error");
}

/// Carries a transfer between client and server until it ends; returns the frames.
std::vector<std::string> Carry(SdoTransfer& transfer, SdoServer& server) {
  std::vector<std::string> frames;
  while (const auto request = transfer.TakeRequest()) {
    frames.push_back(TextOf(*request));
    const auto answer = server.Answer(*request);
    if (!answer) break;
    frames.push_back(TextOf(*answer));
    EXPECT_TRUE(transfer.Take(*answer));
  }
  return frames;
}

ObjectDictionary OneObject(std::vector<std::byte>& value) {
  return {[&](SdoAddress address) -> tl::expected<std::vector<std::byte>, SdoAbort> {
            if (address.index != 0x2004) return tl::unexpected<SdoAbort>(SdoAbort::kNoObject);
            return value;
          },
          [&](SdoAddress, const std::vector<std::byte>& data) -> tl::expected<void, SdoAbort> {
            value = data;
            return {};
          }};
}

TEST(Sdo, UploadsUpToFourBytesAtOnce) {
  std::vector<std::byte> value{std::byte{0x11}, std::byte{0x22}};
  SdoServer server(3, OneObject(value));
  SdoTransfer transfer = SdoTransfer::Upload(3, {0x2004, 1});
  EXPECT_EQ(Carry(transfer, server), (std::vector<std::string>{"603#4004200100000000", "583#4B04200111220000"}));
  EXPECT_EQ(transfer.state(), SdoTransfer::State::kDone);
  EXPECT_EQ(transfer.data(), value);
}

TEST(Sdo, UploadsLongerObjectsInSegmentsWithAlternatingToggle) {
  std::vector<std::byte> value = Bytes("ABCDEFGHI");
  SdoServer server(3, OneObject(value));
  SdoTransfer transfer = SdoTransfer::Upload(3, {0x2004, 0});
  EXPECT_EQ(Carry(transfer, server),
            (std::vector<std::string>{"603#4004200000000000", "583#4104200009000000", "603#6000000000000000",
                                      "583#0041424344454647", "603#7000000000000000", "583#1B48490000000000"}));
  EXPECT_EQ(transfer.data(), value);
}

TEST(Sdo, DownloadsBothWays) {
  std::vector<std::byte> value;
  SdoServer server(3, OneObject(value));
  SdoTransfer small = SdoTransfer::Download(3, {0x2004, 0}, Bytes("abc"));
  EXPECT_EQ(Carry(small, server), (std::vector<std::string>{"603#2704200061626300", "583#6004200000000000"}));
  EXPECT_EQ(value, Bytes("abc"));
  SdoTransfer large = SdoTransfer::Download(3, {0x2004, 0}, Bytes("abcdefgh"));
  EXPECT_EQ(Carry(large, server),
            (std::vector<std::string>{"603#2104200008000000", "583#6004200000000000", "603#0061626364656667",
                                      "583#2000000000000000", "603#1D68000000000000", "583#3000000000000000"}));
  EXPECT_EQ(large.state(), SdoTransfer::State::kDone);
  EXPECT_EQ(value, Bytes("abcdefgh"));
}

TEST(Sdo, CarriesObjectsOfEveryLength) {
  std::mt19937_64 random(1);
  for (std::size_t size = 1; size <= kMostSdoBytes; ++size) {
    std::vector<std::byte> data(size);
    for (std::byte& b : data) b = static_cast<std::byte>(random());
    std::vector<std::byte> value;
    SdoServer server(1, OneObject(value));
    SdoTransfer down = SdoTransfer::Download(1, {0x2004, 0}, data);
    Carry(down, server);
    ASSERT_EQ(value, data);
    SdoTransfer up = SdoTransfer::Upload(1, {0x2004, 0});
    Carry(up, server);
    ASSERT_EQ(up.data(), data);
  }
}

TEST(Sdo, EndsWithTheAbortCodeOfTheNode) {
  std::vector<std::byte> value;
  SdoServer server(3, OneObject(value));
  SdoTransfer transfer = SdoTransfer::Upload(3, {0x1234, 5});
  EXPECT_EQ(Carry(transfer, server), (std::vector<std::string>{"603#4034120500000000", "583#8034120500000206"}));
  EXPECT_EQ(transfer.state(), SdoTransfer::State::kAborted);
  EXPECT_THAT(SdoAbortText(transfer.abort_code()), HasSubstr("no such object"));
}

TEST(Sdo, PassesOverAnswersThatAreNotItsOwn) {
  SdoTransfer transfer = SdoTransfer::Upload(3, {0x2004, 2});
  ASSERT_TRUE(transfer.TakeRequest());
  EXPECT_FALSE(transfer.Take(FrameOf("583#4304200101000000")));  // the sub-index before: a late answer
  EXPECT_FALSE(transfer.Take(FrameOf("584#4304200201000000")));  // another node
  EXPECT_FALSE(transfer.Take(FrameOf("583#6004200200000000")));  // an answer to a download
  EXPECT_FALSE(transfer.Take(FrameOf("583#8004200100000405")));  // an abort of the transfer before
  EXPECT_EQ(transfer.state(), SdoTransfer::State::kRunning);
  EXPECT_TRUE(transfer.Take(FrameOf("583#4304200201000000")));
}

TEST(Sdo, ServerRefusesWrongOrderToggleAndSize) {
  std::vector<std::byte> value = Bytes("ABCDEFGHI");
  SdoServer server(3, OneObject(value));
  EXPECT_EQ(TextOf(*server.Answer(FrameOf("603#6000000000000000"))).substr(4, 2), "80");
  ASSERT_TRUE(server.Answer(FrameOf("603#4004200000000000")));
  EXPECT_EQ(TextOf(*server.Answer(FrameOf("603#7000000000000000"))), "583#8004200000000305");
  ASSERT_TRUE(server.Answer(FrameOf("603#2104200009000000")));
  EXPECT_EQ(TextOf(*server.Answer(FrameOf("603#0F61626300000000"))), "583#8004200010000706");
  EXPECT_EQ(TextOf(*server.Answer(FrameOf("603#C104200000000000"))).substr(4, 2), "80");  // block upload
  EXPECT_FALSE(server.Answer(FrameOf("603#8004200000000405")));
  EXPECT_FALSE(server.Answer(FrameOf("603#40042000000000")));  // seven bytes
}

TEST(SocketCan, WritesTheKernelsStructures) {
  // struct can_frame on a little-endian machine: id, length, three spare bytes, data.
  CanFrame frame = FrameOf("581#0102");
  auto bytes = EncodeSocketCan(frame);
  ASSERT_EQ(bytes.size(), 16U);
  EXPECT_EQ(bytes[0], std::byte{0x81});
  EXPECT_EQ(bytes[1], std::byte{0x05});
  EXPECT_EQ(bytes[4], std::byte{2});
  EXPECT_EQ(bytes[8], std::byte{1});
  frame.extended = true;
  frame.id = 0x1ABCDEF0;
  bytes = EncodeSocketCan(frame);
  EXPECT_EQ(bytes[3], std::byte{0x9A});
  frame = FrameOf("188##" + std::string(128, 'A'));
  bytes = EncodeSocketCan(frame);
  ASSERT_EQ(bytes.size(), 72U);
  EXPECT_EQ(bytes[4], std::byte{64});
  EXPECT_EQ(std::to_integer<int>(bytes[5]) & 1, 1);
}

TEST(SocketCan, ReadsBackEveryFrameItWrites) {
  std::mt19937_64 random(2);
  for (int run = 0; run < 2000; ++run) {
    CanFrame frame;
    frame.extended = random() % 2 == 0;
    frame.id = static_cast<std::uint32_t>(random()) & (frame.extended ? 0x1FFFFFFFU : 0x7FFU);
    frame.fd = random() % 3 == 0;
    frame.bit_rate_switch = frame.fd && random() % 2 == 0;
    frame.remote = !frame.fd && random() % 5 == 0;
    frame.size = static_cast<std::uint8_t>(random() % 9);
    if (frame.fd && random() % 2 == 0) frame.size = std::array<std::uint8_t, 3>{12, 48, 64}[random() % 3];
    for (std::size_t i = 0; i < frame.size && !frame.remote; ++i) frame.data[i] = static_cast<std::byte>(random());
    const auto decoded = DecodeSocketCan(EncodeSocketCan(frame));
    ASSERT_TRUE(decoded);
    EXPECT_EQ(std::get<CanFrame>(*decoded), frame);
  }
}

/// An error frame as the kernel gives it: class bits of linux/can/error.h and eight bytes.
CanReport ReportOf(std::uint32_t classes, std::array<std::uint8_t, 8> data) {
  std::vector<std::byte> bytes(16);
  const std::uint32_t id = classes | 0x20000000U;
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::byte>(id >> (8 * i));
  bytes[4] = std::byte{8};
  for (std::size_t i = 0; i < 8; ++i) bytes[8 + i] = static_cast<std::byte>(data[i]);
  const auto decoded = DecodeSocketCan(bytes);
  EXPECT_TRUE(decoded);
  return std::get<CanReport>(*decoded);
}

TEST(SocketCan, ReadsErrorFrames) {
  EXPECT_EQ(ReportOf(0x40, {}).state, CanState::kBusOff);
  EXPECT_TRUE(ReportOf(0x100, {}).restarted);
  EXPECT_EQ(ReportOf(0x100, {}).state, CanState::kErrorActive);
  EXPECT_TRUE(ReportOf(0x04, {0, 0x01}).receive_overflow);
  EXPECT_FALSE(ReportOf(0x04, {0, 0x01}).state.has_value());
  EXPECT_TRUE(ReportOf(0x04, {0, 0x02}).transmit_overflow);
  EXPECT_EQ(ReportOf(0x04, {0, 0x08, 0, 0, 0, 0, 100, 3}).state, CanState::kErrorWarning);
  EXPECT_EQ(ReportOf(0x04, {0, 0x20, 0, 0, 0, 0, 130, 3}).state, CanState::kErrorPassive);
  EXPECT_EQ(ReportOf(0x04, {0, 0x40}).state, CanState::kErrorActive);
  EXPECT_EQ(ReportOf(0x04, {0, 0x20, 0, 0, 0, 0, 130, 3}).transmit_errors, 130);
  EXPECT_TRUE(ReportOf(0x20, {}).no_acknowledge);
  EXPECT_TRUE(ReportOf(0x08, {}).protocol_error);
  EXPECT_TRUE(ReportOf(0x80, {}).protocol_error);
  EXPECT_TRUE(ReportOf(0x02, {}).lost_arbitration);
}

TEST(SocketCan, RefusesWhatIsNoFrame) {
  EXPECT_FALSE(DecodeSocketCan({}));
  EXPECT_FALSE(DecodeSocketCan(std::vector<std::byte>(15)));
  std::vector<std::byte> too_long(16);
  too_long[4] = std::byte{9};
  EXPECT_FALSE(DecodeSocketCan(too_long));
  std::vector<std::byte> no_fd_length(72);
  no_fd_length[4] = std::byte{9};
  EXPECT_FALSE(DecodeSocketCan(no_fd_length));
}

TEST(CanTiming, TakesTheLongestThatStuffingCanMakeOfAFrame) {
  // Davis, Burns, Bril, Lukkien 2007: at 1 Mbit/s 55 + 10 s us for 11-bit and 80 + 10 s us for 29-bit identifiers.
  for (std::uint8_t size = 0; size <= 8; ++size) {
    CanFrame frame;
    frame.size = size;
    EXPECT_EQ(LongestFrameTime(frame, {}), std::chrono::microseconds(55 + 10 * size));
    frame.extended = true;
    EXPECT_EQ(LongestFrameTime(frame, {}), std::chrono::microseconds(80 + 10 * size));
  }
  // De Andrade et al. 2018 give 32 nominal and 28 + 5 ceil((n - 16) / 64) + 10 n data bits for 11-bit FD frames; we
  // count a few more stuff bits.
  for (const int size : {16, 32, 64}) {
    CanFrame frame;
    frame.fd = true;
    frame.bit_rate_switch = true;
    frame.size = static_cast<std::uint8_t>(size);
    const double known_us = 32.0 + (28.0 + 5.0 * ((size - 16 + 63) / 64) + 10.0 * size) / 4.0;
    const double ours_us = static_cast<double>(LongestFrameTime(frame, {}).count()) / 1000.0;
    EXPECT_GE(ours_us, known_us);
    EXPECT_LE(ours_us, 1.06 * known_us);
  }
}

}  // namespace
}  // namespace annulus
