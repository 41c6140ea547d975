#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <thread>
#include <vector>

#include "firmware_iface/modbus_link.h"
#include "sim/axis_firmware.h"
#include "sim/modbus_server.h"
#include "tests/firmware_iface/modbus_rig.h"
#include "tests/support/faulty_terminal.h"

namespace annulus {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

/// A socket that listens on loopback and that the test answers by hand.
class Listener {
 public:
  Listener() : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<sockaddr*>(&address_), sizeof(address_)), 0);
    EXPECT_EQ(::listen(fd_, 4), 0);
    socklen_t size = sizeof(address_);
    EXPECT_EQ(::getsockname(fd_, reinterpret_cast<sockaddr*>(&address_), &size), 0);
  }
  ~Listener() { ::close(fd_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  [[nodiscard]] int port() const { return ntohs(address_.sin_port); }
  [[nodiscard]] int Accept() const { return ::accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC); }

 private:
  int fd_;
  sockaddr_in address_{};
};

TEST(LibmodbusLink, SaysWhatIsWrongWithAPortThatItCanNotOpen) {
  SystemClock clock;
  const auto missing = OpenModbusRtu({"/dev/serial/by-id/usb-none"}, clock);
  ASSERT_FALSE(missing);
  EXPECT_THAT(missing.error().Text(), HasSubstr("/dev/serial/by-id/usb-none"));
  EXPECT_THAT(missing.error().Text(), HasSubstr("No such file"));
  EXPECT_THAT(missing.error().advice, HasSubstr("group dialout"));
  EXPECT_FALSE(OpenModbusRtu({"/dev/null"}, clock));
}

TEST(LibmodbusLink, RefusesSettingsThatMakeNoSense) {
  SystemClock clock;
  EXPECT_THAT(OpenModbusRtu({""}, clock).error().seen, HasSubstr("no device"));
  EXPECT_THAT(OpenModbusRtu({"/dev/null", 12'345}, clock).error().seen, HasSubstr("12345 baud"));
  EXPECT_THAT(OpenModbusRtu({"/dev/null", 9600, 'X'}, clock).error().seen, HasSubstr("parity 'X'"));
  EXPECT_THAT(OpenModbusRtu({"/dev/null", 9600, 'E', 3}, clock).error().seen, HasSubstr("3 stop bits"));
  EXPECT_THAT(OpenModbusRtu({"/dev/null", 9600, 'E', 1, 248}, clock).error().seen, HasSubstr("unit 248"));
  EXPECT_THAT(OpenModbusTcp({"drive.example", 502}, clock).error().seen, HasSubstr("not an address in digits"));
  EXPECT_THAT(OpenModbusTcp({"127.0.0.1", 0}, clock).error().seen, HasSubstr("1 to 65535"));
  EXPECT_THAT(OpenModbusTcp({"127.0.0.1", 502, 300}, clock).error().seen, HasSubstr("unit 300"));
}

TEST(LibmodbusLink, TellsThatNobodyListens) {
  SystemClock clock;
  int port = 0;
  {
    const Listener closed_again;
    port = closed_again.port();
  }
  const auto refused = OpenModbusTcp({"127.0.0.1", port}, clock);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().seen, HasSubstr("Connection refused"));
}

TEST(LibmodbusLink, RefusesASecondNameOfAPortThatIsOpen) {
  SystemClock clock;
  sim::AxisDriveModel drive(ContractDrive(1.0), clock);
  const auto folder = std::filesystem::temp_directory_path();
  const std::string first = (folder / ("annulus-first-" + std::to_string(::getpid()))).string();
  const std::string second = (folder / ("annulus-second-" + std::to_string(::getpid()))).string();
  sim::ModbusServerOptions options;
  options.symlink = first;
  auto server = sim::ModbusServer::Start(drive, options);
  ASSERT_TRUE(server) << server.error().Text();
  std::filesystem::create_symlink(std::filesystem::read_symlink(first), second);
  auto link = OpenModbusRtu({first, 115'200, 'N'}, clock);
  ASSERT_TRUE(link) << link.error().Text();
  const auto twice = OpenModbusRtu({second, 115'200, 'N'}, clock);
  ASSERT_FALSE(twice);
  EXPECT_THAT(twice.error().seen, HasSubstr("under another name"));
  EXPECT_THAT(twice.error().seen, HasSubstr("/dev/pts/"));
  link->reset();
  EXPECT_TRUE(OpenModbusRtu({second, 115'200, 'N'}, clock));
  std::filesystem::remove(second);
}

TEST(LibmodbusLink, DoesNotDisturbTheProgramThatHasThePort) {
  SystemClock clock;
  sim::AxisDriveModel drive(ContractDrive(1.0), clock);
  auto server = sim::ModbusServer::Start(drive, {});
  ASSERT_TRUE(server) << server.error().Text();
  const std::string port = (*server)->device_name();
  auto link = OpenModbusRtu({port, 115'200, 'N'}, clock);
  ASSERT_TRUE(link) << link.error().Text();
  std::atomic<int> refused = 0;
  std::thread intruder([&] {
    for (int attempt = 0; attempt < 20; ++attempt) {
      if (!OpenModbusRtu({port, 9'600, 'N'}, clock)) ++refused;
      clock.SleepUntil(clock.Now() + milliseconds(5));
    }
  });
  int answered = 0;
  for (int exchange = 0; exchange < 200; ++exchange) {
    if ((*link)->Transact({ModbusFunction::kReadRegisters, 0, {}, 0x0100, 8}, std::chrono::seconds(2))) ++answered;
  }
  intruder.join();
  EXPECT_EQ(refused, 20);
  EXPECT_EQ(answered, 200);
  const int fd = ::open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(fd, 0);
  termios settings{};
  EXPECT_EQ(::tcgetattr(fd, &settings), 0);
  ::close(fd);
  EXPECT_EQ(::cfgetospeed(&settings), static_cast<speed_t>(B115200));
}

TEST(LibmodbusLink, ClosesAConnectionByReset) {
  SystemClock clock;
  const Listener listener;
  auto link = OpenModbusTcp({"127.0.0.1", listener.port()}, clock);
  ASSERT_TRUE(link) << link.error().Text();
  const int peer = listener.Accept();
  ASSERT_GE(peer, 0);
  (*link)->Close();
  char byte = 0;
  pollfd waiting{peer, POLLIN, 0};
  ASSERT_EQ(::poll(&waiting, 1, 5'000), 1);
  EXPECT_EQ(::recv(peer, &byte, 1, 0), -1);
  EXPECT_EQ(errno, ECONNRESET);
  ::close(peer);
}

TEST(LibmodbusLink, SendsARequestOnceHoweverLongNobodyAnswers) {
  SystemClock clock;
  const Listener listener;
  auto link = OpenModbusTcp({"127.0.0.1", listener.port()}, clock);
  ASSERT_TRUE(link) << link.error().Text();
  const int peer = listener.Accept();
  ASSERT_GE(peer, 0);
  const auto reply = (*link)->Transact({ModbusFunction::kWriteReadRegisters, 0x0000, {1}, 0x0100, 2}, milliseconds(50));
  ASSERT_FALSE(reply);
  EXPECT_EQ(reply.error().fault, ModbusFault::kTimeout);
  std::array<std::uint8_t, 64> sent{};
  // MBAP 7, function, two addresses and counts 9, one register: 19 bytes of one request.
  EXPECT_EQ(::recv(peer, sent.data(), sent.size(), 0), 19);
  EXPECT_EQ(::recv(peer, sent.data(), sent.size(), MSG_DONTWAIT), -1);
  ::close(peer);
  const auto lost = (*link)->Transact({ModbusFunction::kReadRegisters, 0, {}, 0x0100, 2}, milliseconds(500));
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().fault, ModbusFault::kLinkLost);
}

/// A request of the axis as docs/wire_protocol.md §4 prints it, and a reply.
struct GoldenExchange {
  ModbusFraming framing;
  const char* request;
  const char* reply;
};
// Made with Python: pdu = struct.pack('>BHHHHBH', 0x17, 0x0100, 8, 0, 1, 2, 0x1234); reply = struct.pack('>BB8H', 0x17,
// 16, 0x1234, 0x0237, 0, 0x000F, 0x4240, 1, 0x86A0, 1); TCP: struct.pack('>HHHB', 1, 0, len(pdu) + 1, 1) + pdu; RTU:
// b'\x01' + pdu + CRC-16 (polynomial A001h reflected, start FFFFh, low byte first).
constexpr std::array<GoldenExchange, 2> kGolden{
    {{ModbusFraming::kTcp, "00010000000d01170100000800000001021234",
      "000100000013011710123402370000000f4240000186a00001"},
     {ModbusFraming::kRtu, "011701000008000000010212349d4f", "011710123402370000000f4240000186a0000100d5"}}};

std::vector<std::uint8_t> FromHex(const std::string& text) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

TEST(LibmodbusLink, SpeaksTheGoldenBytesOfBothFramings) {
  for (const GoldenExchange& golden : kGolden) {
    std::array<int, 2> ends{};
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    auto link = AdoptModbusDescriptor(ends[0], golden.framing, 1);
    ASSERT_TRUE(link) << link.error().Text();
    const std::vector<std::uint8_t> answer = FromHex(golden.reply);
    ASSERT_EQ(::write(ends[1], answer.data(), answer.size()), static_cast<ssize_t>(answer.size()));
    const auto reply =
        (*link)->Transact({ModbusFunction::kWriteReadRegisters, 0x0000, {0x1234}, 0x0100, 8}, milliseconds(5000));
    ASSERT_TRUE(reply) << ModbusFailureText(reply.error());
    EXPECT_EQ(*reply, (std::vector<std::uint16_t>{0x1234, 0x0237, 0, 0x000F, 0x4240, 1, 0x86A0, 1}));
    std::vector<std::uint8_t> sent(64);
    const ssize_t size = ::recv(ends[1], sent.data(), sent.size(), 0);
    ASSERT_GT(size, 0);
    sent.resize(static_cast<std::size_t>(size));
    EXPECT_EQ(sent, FromHex(golden.request));
    ::close(ends[1]);
  }
}

/// Refuses everything with one exception code.
class RefusingDevice final : public ModbusLink {
 public:
  std::atomic<std::uint8_t> code = 1;
  ModbusReply Transact(const ModbusRequest&, std::chrono::nanoseconds) override {
    return tl::unexpected<ModbusFailure>(ModbusFailure{ModbusFault::kException, code, {}});
  }
  void DiscardInput() override {}
  void Close() override {}
  tl::expected<void, ModbusFailure> Reopen() override { return {}; }
};

TEST(LibmodbusLink, TellsEveryExceptionByItsCode) {
  SystemClock clock;
  RefusingDevice device;
  sim::ModbusServerOptions options;
  options.tcp_port = 0;
  auto server = sim::ModbusServer::Start(device, options);
  ASSERT_TRUE(server) << server.error().Text();
  auto link = OpenModbusTcp({"127.0.0.1", (*server)->port()}, clock);
  ASSERT_TRUE(link) << link.error().Text();
  for (const int code : {1, 2, 3, 4, 5, 6, 10, 11}) {
    device.code = static_cast<std::uint8_t>(code);
    const auto reply = (*link)->Transact({ModbusFunction::kWriteReadRegisters, 0, {1}, 0, 2}, std::chrono::seconds(5));
    ASSERT_FALSE(reply);
    EXPECT_EQ(reply.error().fault, ModbusFault::kException);
    EXPECT_EQ(reply.error().exception_code, code);
  }
}

TEST(LibmodbusLink, TellsADamagedReplyFromNoReply) {
  SystemClock clock;
  sim::AxisDriveModel drive(ContractDrive(1.0), clock);
  auto server = sim::ModbusServer::Start(drive, {});
  ASSERT_TRUE(server) << server.error().Text();
  std::atomic<int> kind = 0;
  FaultyTerminal terminal((*server)->device_name(), [&] {
    ByteFate fate;
    fate.damaged = kind == 1;
    fate.copies = kind == 2 ? 0 : 1;
    return fate;
  });
  auto link = OpenModbusRtu({terminal.device_name(), 115'200, 'N'}, clock);
  ASSERT_TRUE(link) << link.error().Text();
  const auto read = [&](std::chrono::nanoseconds timeout) {
    const auto reply = (*link)->Transact({ModbusFunction::kReadRegisters, 0, {}, 0x0108, 4}, timeout);
    clock.SleepUntil(clock.Now() + milliseconds(50));
    (*link)->DiscardInput();
    return reply;
  };
  EXPECT_TRUE(read(std::chrono::seconds(5)));
  kind = 1;
  const auto damaged = read(std::chrono::seconds(5));
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().fault, ModbusFault::kBadReply);
  EXPECT_THAT(ModbusFailureText(damaged.error()), HasSubstr("CRC"));
  kind = 2;
  const auto none = read(milliseconds(50));
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().fault, ModbusFault::kTimeout);
  kind = 0;
  EXPECT_TRUE(read(std::chrono::seconds(5)));
}

TEST(LibmodbusLink, H8_RefusesDescriptorsThatSelectCanNotTake) {
  rlimit limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &limit), 0);
  const rlimit before = limit;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, 4096);
  if (limit.rlim_cur < 1200) GTEST_SKIP() << "this host allows only " << limit.rlim_cur << " open files";
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &limit), 0);
  SystemClock clock;
  const Listener listener;
  std::vector<int> many;
  while (many.empty() || many.back() < 1'023) many.push_back(::dup(0));
  const auto beyond = OpenModbusTcp({"127.0.0.1", listener.port()}, clock);
  for (const int fd : many) ::close(fd);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  ASSERT_FALSE(beyond);
  EXPECT_THAT(beyond.error().seen, HasSubstr("beyond select()'s limit of 1024"));
  EXPECT_TRUE(OpenModbusTcp({"127.0.0.1", listener.port()}, clock));
}

TEST(LibmodbusLink, ListsPortsByTheirFullNames) {
  for (const std::string& port : ListSerialPorts()) EXPECT_THAT(port, HasSubstr("/dev/serial/by-id/"));
}

}  // namespace
}  // namespace annulus
