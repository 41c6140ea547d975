#include "sim/modbus_server.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "sim/axis_firmware.h"

namespace annulus::sim {
namespace {

using Bytes = std::vector<std::uint8_t>;
using std::chrono::milliseconds;

AxisDriveOptions PromptDrive() {
  AxisDriveOptions options;
  options.wire_delay = options.wire_jitter = std::chrono::nanoseconds(0);
  return options;
}

class ModbusServerTest : public testing::Test {
 protected:
  void Start(ModbusServerOptions options) {
    auto started = ModbusServer::Start(drive_, std::move(options));
    ASSERT_TRUE(started) << started.error().Text();
    server_ = std::move(*started);
  }
  void StartTcp() {
    ModbusServerOptions options;
    options.tcp_port = 0;
    Start(options);
    ASSERT_GT(server_->port(), 0);
  }
  [[nodiscard]] int Connect() const {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(server_->port()));
    EXPECT_EQ(::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
    return fd;
  }
  /// Sends bytes and takes what comes back within two seconds; nothing if the connection is closed first.
  static Bytes Exchange(int fd, const Bytes& sent) {
    EXPECT_EQ(::send(fd, sent.data(), sent.size(), MSG_NOSIGNAL), static_cast<ssize_t>(sent.size()));
    pollfd waiting{fd, POLLIN, 0};
    Bytes came(512);
    const ssize_t got = ::poll(&waiting, 1, 2'000) == 1 ? ::recv(fd, came.data(), came.size(), 0) : 0;
    came.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    return came;
  }
  /// A request with its Modbus TCP header: transaction 7, unit 1.
  static Bytes Framed(const Bytes& pdu) {
    Bytes frame{0, 7, 0, 0, 0, static_cast<std::uint8_t>(pdu.size() + 1), 1};
    frame.insert(frame.end(), pdu.begin(), pdu.end());
    return frame;
  }
  void ExpectServes() {
    auto link = OpenModbusTcp({"127.0.0.1", server_->port()}, clock_);
    ASSERT_TRUE(link) << link.error().Text();
    const auto reply = (*link)->Transact({ModbusFunction::kReadRegisters, 0, {}, 0x010A, 2}, std::chrono::seconds(5));
    ASSERT_TRUE(reply) << ModbusFailureText(reply.error());
    EXPECT_EQ(*reply, (std::vector<std::uint16_t>{0, 4711}));
  }

  SystemClock clock_;
  AxisDriveModel drive_{PromptDrive(), clock_};
  std::unique_ptr<ModbusServer> server_;
};

// Expected bytes: MODBUS Application Protocol V1.1b3, section 7 (function with its high bit set, exception code).
TEST_F(ModbusServerTest, RefusesWhatMakesNoSenseWithTheExceptionOfTheStandard) {
  StartTcp();
  struct Case {
    Bytes request;
    Bytes exception;
  };
  const Case cases[] = {
      {{0x03, 0x01, 0x00, 0x00, 0x00}, {0x83, 3}},                          // nothing to read
      {{0x03, 0x01, 0x00, 0x00, 0x7E}, {0x83, 3}},                          // 126 registers
      {{0x03, 0x01, 0x10, 0x00, 0x7D}, {0x83, 2}},                          // beyond the last one
      {{0x06, 0x01, 0x00, 0x00, 0x01}, {0x86, 2}},                          // read-only
      {{0x10, 0x00, 0x00, 0x00, 0x01, 0x04, 0, 1, 0, 2}, {0x90, 3}},        // two counts disagree
      {{0x17, 0x01, 0x00, 0x00, 0x02, 0, 0, 0, 2, 0x02, 0, 1}, {0x97, 3}},  // the same
      {{0x17, 0x40, 0x00, 0x00, 0x02, 0, 0, 0, 1, 0x02, 0, 1}, {0x97, 2}},  // nowhere
      {{0x01, 0x00, 0x00, 0x00, 0x01}, {0x81, 1}},                          // coils: not ours
      {{0x16, 0x00, 0x00, 0xFF, 0xFF, 0x00, 0x00}, {0x96, 1}},              // mask write: not ours
      {{0x07}, {0x87, 1}},                                                  // serial line only
      {{0x2B, 0x0E, 0x01, 0x00}, {0xAB, 1}},                                // device identification
  };
  for (const Case& refused : cases) {
    const int fd = Connect();
    const Bytes reply = Exchange(fd, Framed(refused.request));
    ::close(fd);
    ASSERT_EQ(reply.size(), 9U) << "function " << int{refused.request[0]};
    EXPECT_EQ(Bytes(reply.begin() + 7, reply.end()), refused.exception);
  }
  ExpectServes();
}

TEST_F(ModbusServerTest, SurvivesWhatIsNoModbusAtAll) {
  StartTcp();
  std::mt19937 random(3);
  for (int attempt = 0; attempt < 40; ++attempt) {
    const int fd = Connect();
    Bytes noise(1 + random() % 700);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
    EXPECT_GE(::send(fd, noise.data(), noise.size(), MSG_NOSIGNAL), 0);
    ::close(fd);
  }
  ExpectServes();
}

TEST_F(ModbusServerTest, ServesSeveralMastersInTurnOneOfThemSilentInMidRequest) {
  StartTcp();
  const int silent = Connect();
  EXPECT_EQ(::send(silent, "\0\1\0\0", 4, MSG_NOSIGNAL), 4);
  std::vector<std::unique_ptr<ModbusLink>> masters;
  for (int i = 0; i < 5; ++i) {
    auto link = OpenModbusTcp({"127.0.0.1", server_->port()}, clock_);
    ASSERT_TRUE(link) << link.error().Text();
    masters.push_back(std::move(*link));
  }
  for (std::uint16_t round = 0; round < 20; ++round) {
    for (auto& master : masters) {
      const auto reply =
          master->Transact({ModbusFunction::kWriteReadRegisters, 0x0000, {round}, 0x0100, 1}, std::chrono::seconds(5));
      ASSERT_TRUE(reply) << ModbusFailureText(reply.error());
      EXPECT_EQ(reply->at(0), round);
    }
  }
  ::close(silent);
}

TEST_F(ModbusServerTest, NamesItsTerminalAndTakesTheNameAwayAgain) {
  const auto folder = std::filesystem::temp_directory_path();
  const std::string name = (folder / ("annulus-server-" + std::to_string(::getpid()))).string();
  ModbusServerOptions options;
  options.symlink = name;
  Start(options);
  EXPECT_EQ(server_->device_name(), name);
  EXPECT_TRUE(std::filesystem::is_symlink(name));
  server_.reset();
  EXPECT_FALSE(std::filesystem::is_symlink(name));
  options.symlink = (folder / "no-such-folder" / "axis").string();
  const auto failed = ModbusServer::Start(drive_, options);
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().Text(), testing::HasSubstr("no-such-folder"));
}

TEST_F(ModbusServerTest, IgnoresNoiseAndOtherUnitsOnASerialLine) {
  Start({});
  const int line = ::open(server_->device_name().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_GE(line, 0);
  // FC03 of unit 2, register 0, count 1; the checksum was made with Python's bitwise CRC-16 (polynomial A001h).
  const Bytes for_another{0x02, 0x03, 0x00, 0x00, 0x00, 0x01, 0x84, 0x39};
  const Bytes noise{0x01, 0x17, 0xFF, 0x00, 0x13};
  for (const Bytes& bytes : {for_another, noise}) {
    ASSERT_EQ(::write(line, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
    clock_.SleepUntil(clock_.Now() + milliseconds(150));  // silence ends a frame
  }
  ::close(line);
  auto link = OpenModbusRtu({server_->device_name(), 115'200, 'N'}, clock_);
  ASSERT_TRUE(link) << link.error().Text();
  const auto reply = (*link)->Transact({ModbusFunction::kReadRegisters, 0, {}, 0x010A, 2}, std::chrono::seconds(5));
  ASSERT_TRUE(reply) << ModbusFailureText(reply.error());
  EXPECT_EQ(*reply, (std::vector<std::uint16_t>{0, 4711}));
}

}  // namespace
}  // namespace annulus::sim
