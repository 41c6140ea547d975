#include "sim/usbredir_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <usbredirparser.h>

#include <array>
#include <cstring>
#include <map>
#include <string>

#include "firmware_iface/usb_frame_codec.h"
#include "tests/sim/booth_fixture.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

/// The other end of the protocol: what QEMU's usb-redir does, by the library's own parser.
class Machine {
 public:
  explicit Machine(OwnedFd socket) : socket_(std::move(socket)), parser_(usbredirparser_create()) {
    parser_->priv = this;
    parser_->log_func = [](void*, int, const char*) {};
    parser_->read_func = [](void* self, std::uint8_t* data, int count) {
      const ssize_t size = ::recv(Fd(self), data, static_cast<std::size_t>(count), MSG_DONTWAIT);
      return size < 0 ? 0 : size == 0 ? -1 : static_cast<int>(size);
    };
    parser_->write_func = [](void* self, std::uint8_t* data, int count) {
      const ssize_t size = ::send(Fd(self), data, static_cast<std::size_t>(count), MSG_DONTWAIT | MSG_NOSIGNAL);
      return static_cast<int>(size);
    };
    parser_->hello_func = [](void*, usb_redir_hello_header*) {};
    parser_->interface_info_func = [](void*, usb_redir_interface_info_header*) {};
    parser_->ep_info_func = [](void* self, usb_redir_ep_info_header* header) { From(self).endpoints = *header; };
    parser_->device_connect_func = [](void* self, usb_redir_device_connect_header* header) {
      ++From(self).connected;
      From(self).device = *header;
    };
    parser_->device_disconnect_func = [](void* self) { ++From(self).disconnected; };
    parser_->configuration_status_func = [](void* self, std::uint64_t, usb_redir_configuration_status_header* header) {
      From(self).configuration_status = header->status;
    };
    parser_->bulk_receiving_status_func = [](void* self, std::uint64_t,
                                             usb_redir_bulk_receiving_status_header* header) {
      From(self).receiving_status = header->status;
    };
    parser_->control_packet_func = [](void* self, std::uint64_t id, usb_redir_control_packet_header* header,
                                      std::uint8_t* data,
                                      int size) { From(self).Keep(id, header->status, data, size); };
    parser_->bulk_packet_func = [](void* self, std::uint64_t id, usb_redir_bulk_packet_header* header,
                                   std::uint8_t* data, int size) { From(self).Keep(id, header->status, data, size); };
    parser_->buffered_bulk_packet_func = [](void* self, std::uint64_t, usb_redir_buffered_bulk_packet_header*,
                                            std::uint8_t* data, int size) {
      auto& all = From(self).stream;
      const auto bytes = std::as_bytes(std::span(data, static_cast<std::size_t>(size)));
      all.insert(all.end(), bytes.begin(), bytes.end());
      usbredirparser_free_packet_data(From(self).parser_, data);
    };
    std::array<std::uint32_t, USB_REDIR_CAPS_SIZE> caps{};
    for (const int cap : {usb_redir_cap_connect_device_version, usb_redir_cap_ep_info_max_packet_size,
                          usb_redir_cap_64bits_ids, usb_redir_cap_32bits_bulk_length, usb_redir_cap_bulk_receiving}) {
      usbredirparser_caps_set_cap(caps.data(), cap);
    }
    usbredirparser_init(parser_, "test", caps.data(), caps.size(), 0);
  }
  ~Machine() { usbredirparser_destroy(parser_); }
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  struct Reply {
    int status = -1;
    std::vector<std::byte> data;
  };

  void Exchange() {
    while (usbredirparser_has_data_to_write(parser_) > 0) usbredirparser_do_write(parser_);
    usbredirparser_do_read(parser_);
  }
  void ControlIn(std::uint64_t id, std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t length) {
    usb_redir_control_packet_header header{};
    header.endpoint = 0x80;
    header.requesttype = type;
    header.request = request;
    header.value = value;
    header.length = length;
    usbredirparser_send_control_packet(parser_, id, &header, nullptr, 0);
  }
  void ControlOut(std::uint64_t id, BoardRequest request, std::vector<std::uint8_t> data) {
    usb_redir_control_packet_header header{};
    header.requesttype = 0x40;
    header.request = static_cast<std::uint8_t>(request);
    header.length = static_cast<std::uint16_t>(data.size());
    usbredirparser_send_control_packet(parser_, id, &header, data.data(), header.length);
  }
  void BulkIn(std::uint64_t id, std::uint16_t length, std::uint8_t endpoint = kLevelEndpoint) {
    usb_redir_bulk_packet_header header{};
    header.endpoint = endpoint;
    header.length = length;
    usbredirparser_send_bulk_packet(parser_, id, &header, nullptr, 0);
  }
  void Cancel(std::uint64_t id) { usbredirparser_send_cancel_data_packet(parser_, id); }
  void SetConfiguration() {
    usb_redir_set_configuration_header header{1};
    usbredirparser_send_set_configuration(parser_, 1, &header);
  }
  void StartReceiving() {
    usb_redir_start_bulk_receiving_header header{0, 1024, kLevelEndpoint, 4};
    usbredirparser_send_start_bulk_receiving(parser_, 1, &header);
  }
  void StopReceiving() {
    usb_redir_stop_bulk_receiving_header header{0, kLevelEndpoint};
    usbredirparser_send_stop_bulk_receiving(parser_, 2, &header);
  }
  void SendRaw(const std::string& bytes) { EXPECT_GT(::send(socket_.get(), bytes.data(), bytes.size(), 0), 0); }
  void Close() { socket_ = OwnedFd(); }

  usb_redir_ep_info_header endpoints{};
  usb_redir_device_connect_header device{};
  int connected = 0;
  int disconnected = 0;
  int configuration_status = -1;
  int receiving_status = -1;
  std::map<std::uint64_t, Reply> replies;
  std::vector<std::byte> stream;

 private:
  static Machine& From(void* self) { return *static_cast<Machine*>(self); }
  static int Fd(void* self) { return From(self).socket_.get(); }
  void Keep(std::uint64_t id, int status, std::uint8_t* data, int size) {
    const auto bytes = std::as_bytes(std::span(data, data == nullptr ? 0 : static_cast<std::size_t>(size)));
    replies[id] = {status, {bytes.begin(), bytes.end()}};
    usbredirparser_free_packet_data(parser_, data);
  }

  OwnedFd socket_;
  usbredirparser* parser_;
};

std::vector<int> Numbers(const std::vector<std::byte>& bytes) {
  std::vector<int> numbers;
  numbers.reserve(bytes.size());
  for (const std::byte byte : bytes) numbers.push_back(std::to_integer<int>(byte));
  return numbers;
}

/// A board of the simulated booth on a socket, in virtual time.
class UsbredirDeviceTest : public testing::Test {
 protected:
  UsbredirDeviceTest() : booth_(Options()) {
    std::array<int, 2> pair{-1, -1};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair.data()), 0);
    device_ = MakeUsbredirDevice(booth_.board(0), OwnedFd(pair[0]));
    machine_ = std::make_unique<Machine>(OwnedFd(pair[1]));
    Run(2);
  }
  static BoothOptions Options() {
    BoothOptions options = CylinderBooth();
    options.axis.start_z_mm = 500.0;
    return options;
  }
  /// Some rounds of a millisecond.
  void Run(int rounds) {
    for (int i = 0; i < rounds; ++i) {
      machine_->Exchange();
      EXPECT_TRUE(device_->Serve());
      machine_->Exchange();
      booth_.clock().SleepUntil(booth_.clock().Now() + milliseconds(1));
    }
  }
  void StartLevels() {
    machine_->ControlOut(900, BoardRequest::kArm, {0x50, 0xC3, 0, 0});  // 50,000 mHz
    machine_->ControlOut(901, BoardRequest::kStartSync, {});
    Run(2);
    EXPECT_EQ(machine_->replies[900].status, usb_redir_success);
    EXPECT_EQ(machine_->replies[901].status, usb_redir_success);
  }
  static void ExpectLevels(const std::vector<std::byte>& bytes, std::size_t least) {
    UsbFrameAssembler assembler;
    const auto frames = assembler.Push(bytes);
    ASSERT_GE(frames.size(), least);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_EQ(frames[i].sequence, i);
      EXPECT_EQ(frames[i].range_um[0], 450'000U);
    }
    EXPECT_EQ(assembler.rejected_bytes(), 0U);
  }

  Booth booth_;
  std::unique_ptr<UsbredirDevice> device_;
  std::unique_ptr<Machine> machine_;
};

TEST_F(UsbredirDeviceTest, IntroducesItselfAsAHighSpeedVendorDevice) {
  EXPECT_EQ(machine_->connected, 1);
  EXPECT_EQ(machine_->device.vendor_id, 0x1209);
  EXPECT_EQ(machine_->device.product_id, 0xA180);
  EXPECT_EQ(machine_->device.speed, usb_redir_speed_high);
  EXPECT_EQ(machine_->endpoints.type[17], usb_redir_type_bulk);
  EXPECT_EQ(machine_->endpoints.max_packet_size[17], 512);
  machine_->SetConfiguration();
  Run(2);
  EXPECT_EQ(machine_->configuration_status, usb_redir_success);
}

TEST_F(UsbredirDeviceTest, AnswersTheDescriptorsOfChapterNine) {
  machine_->ControlIn(10, 0x80, 6, 0x0100, 64);
  machine_->ControlIn(11, 0x80, 6, 0x0200, 255);
  machine_->ControlIn(12, 0x80, 6, 0x0200, 9);
  machine_->ControlIn(13, 0x80, 6, 0x0303, 255);
  machine_->ControlIn(14, 0x80, 6, 0x0600, 10);  // device qualifier: high speed only, so there is none
  Run(3);
  EXPECT_THAT(Numbers(machine_->replies[10].data),
              ElementsAre(18, 1, 0x00, 0x02, 0, 0, 0, 64, 0x09, 0x12, 0x80, 0xA1, 0x20, 0x01, 1, 2, 3, 1));
  EXPECT_THAT(Numbers(machine_->replies[11].data), ElementsAre(9, 2, 25, 0, 1, 1, 0, 0xC0, 0,  //
                                                               9, 4, 0, 0, 1, 0xFF, 0, 0, 0,   //
                                                               7, 5, 0x81, 2, 0x00, 0x02, 0));
  EXPECT_EQ(machine_->replies[12].data.size(), 9U);
  EXPECT_THAT(Numbers(machine_->replies[13].data), ElementsAre(14, 3, 'R', 0, 'B', 0, '1', 0, '0', 0, '0', 0, '1', 0));
  EXPECT_EQ(machine_->replies[14].status, usb_redir_stall);
}

TEST_F(UsbredirDeviceTest, PassesVendorRequestsToTheFirmware) {
  machine_->ControlIn(20, 0xC0, static_cast<std::uint8_t>(BoardRequest::kIdentify), 0, kBoardIdentityBytes);
  machine_->ControlIn(21, 0xC0, 0x77, 0, 8);
  Run(3);
  const auto identity = DecodeBoardIdentity(machine_->replies[20].data);
  ASSERT_TRUE(identity) << identity.error().Text();
  EXPECT_EQ(identity->serial, 1001U);
  EXPECT_EQ(machine_->replies[21].status, usb_redir_stall);
}

TEST_F(UsbredirDeviceTest, StreamsLevelsByBulkPackets) {
  StartLevels();
  std::vector<std::byte> bytes;
  std::uint64_t id = 1000;
  machine_->BulkIn(id, 2048);
  for (int i = 0; i < 500; ++i) {
    Run(1);
    if (machine_->replies.count(id) == 0) continue;
    EXPECT_EQ(machine_->replies[id].status, usb_redir_success);
    bytes.insert(bytes.end(), machine_->replies[id].data.begin(), machine_->replies[id].data.end());
    machine_->BulkIn(++id, 2048);
  }
  ExpectLevels(bytes, 20);
}

TEST_F(UsbredirDeviceTest, StreamsLevelsByBulkReceiving) {
  StartLevels();
  machine_->StartReceiving();
  Run(500);
  EXPECT_EQ(machine_->receiving_status, usb_redir_success);
  ExpectLevels(machine_->stream, 20);
  machine_->StopReceiving();
  Run(3);
  EXPECT_EQ(device_->in_flight(), 0U);
  const std::size_t received = machine_->stream.size();
  Run(100);
  EXPECT_EQ(machine_->stream.size(), received);
}

TEST_F(UsbredirDeviceTest, EndsACancelledTransferAndRefusesWhatTheBoardHasNot) {
  machine_->BulkIn(30, 512);
  machine_->BulkIn(31, 512, 0x82);
  machine_->BulkIn(32, 0);
  Run(2);
  EXPECT_EQ(device_->in_flight(), 1U);
  EXPECT_EQ(machine_->replies[31].status, usb_redir_inval);
  EXPECT_EQ(machine_->replies[32].status, usb_redir_inval);
  EXPECT_EQ(machine_->replies.count(30), 0U);
  machine_->Cancel(30);
  Run(2);
  EXPECT_EQ(machine_->replies[30].status, usb_redir_cancelled);
  EXPECT_EQ(device_->in_flight(), 0U);
}

TEST_F(UsbredirDeviceTest, GoesInMidTransferAndComesBackAsANewDevice) {
  for (int round = 0; round < 3; ++round) {
    StartLevels();
    const auto first = 2000 + static_cast<std::uint64_t>(round) * 10;
    for (std::uint64_t id = first; id < first + 8; ++id) machine_->BulkIn(id, 2048);
    Run(50);
    device_->Unplug();
    Run(2);
    EXPECT_EQ(machine_->disconnected, round + 1);
    EXPECT_EQ(device_->in_flight(), 0U);
    EXPECT_EQ(booth_.board(0).in_flight(), 0U);
    EXPECT_EQ(machine_->replies.count(first + 7), 0U);
    device_->Plug();
    Run(2);
    EXPECT_EQ(machine_->connected, round + 2);
  }
}

TEST_F(UsbredirDeviceTest, SaysThatTheMachineIsGone) {
  StartLevels();
  machine_->BulkIn(40, 2048);
  Run(1);
  machine_->Close();
  Status served;
  for (int i = 0; i < 3 && served; ++i) served = device_->Serve();
  ASSERT_FALSE(served);
  EXPECT_THAT(served.error().Text(), testing::HasSubstr("closed the socket"));
}

TEST_F(UsbredirDeviceTest, RefusesBytesThatAreNoUsbredir) {
  machine_->SendRaw("GET / HTTP/1.1\r\nHost: booth\r\n\r\n");
  Status served;
  for (int i = 0; i < 3 && served; ++i) served = device_->Serve();
  EXPECT_FALSE(served);
}

}  // namespace
}  // namespace annulus::sim
