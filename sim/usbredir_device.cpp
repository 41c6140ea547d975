#include "sim/usbredir_device.h"

#include <poll.h>
#include <sys/socket.h>
#include <usbredirparser.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <optional>
#include <span>
#include <utility>

#include "base/log.h"
#include "firmware_iface/usb_frame_codec.h"
#include "sim/usb_descriptors.h"

namespace annulus::sim {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// The board answers within a fraction of it.
constexpr nanoseconds kControlTimeout = milliseconds(100);
constexpr nanoseconds kPoll = milliseconds(1);
constexpr nanoseconds kIdlePoll = milliseconds(20);
constexpr nanoseconds kLongAgo{0};
/// What one machine may have in flight with one board.
constexpr std::size_t kMostTransfers = 256;
constexpr std::size_t kMostTransferBytes = std::size_t{1} << 20;

constexpr std::uint8_t kDirectionIn = 0x80;

/// Index of an endpoint in the tables of usbredir: 0 … 15 out, 16 … 31 in.
constexpr std::size_t TableIndex(std::uint8_t endpoint) {
  return static_cast<std::size_t>((endpoint & 0x80U) >> 3 | (endpoint & 0x0FU));
}

std::uint8_t WireStatus(UsbStatus status) {
  switch (status) {
    case UsbStatus::kCompleted:
      return usb_redir_success;
    case UsbStatus::kCancelled:
      return usb_redir_cancelled;
    case UsbStatus::kStall:
      return usb_redir_stall;
    case UsbStatus::kTimedOut:
      return usb_redir_timeout;
    case UsbStatus::kOverflow:
      return usb_redir_babble;
    default:
      return usb_redir_ioerror;
  }
}

class Device final : public UsbredirDevice {
 public:
  Device(UsbPort& board, OwnedFd socket) : board_(board), socket_(std::move(socket)), parser_(usbredirparser_create()) {
    parser_->priv = this;
    SetTransport();
    SetControlPackets();
    SetDataPackets();
    SetIgnoredPackets();
    std::array<std::uint32_t, USB_REDIR_CAPS_SIZE> caps{};
    for (const int cap : {usb_redir_cap_connect_device_version, usb_redir_cap_device_disconnect_ack,
                          usb_redir_cap_ep_info_max_packet_size, usb_redir_cap_64bits_ids,
                          usb_redir_cap_32bits_bulk_length, usb_redir_cap_bulk_receiving}) {
      usbredirparser_caps_set_cap(caps.data(), cap);
    }
    usbredirparser_init(parser_.get(), "annulus ring board", caps.data(), caps.size(), usbredirparser_fl_usb_host);
  }
  ~Device() override { DropAll(); }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  [[nodiscard]] int socket() const override { return socket_.get(); }
  [[nodiscard]] bool wants_to_write() const override { return usbredirparser_has_data_to_write(parser_.get()) > 0; }
  [[nodiscard]] std::size_t in_flight() const override { return transfers_.size(); }
  [[nodiscard]] std::uint64_t sent_bytes() const override { return sent_bytes_; }
  Status Serve() override;
  void Unplug() override;
  void Plug() override;

 private:
  /// A bulk transfer that the machine waits for: a packet of its own, or one of a running stream.
  struct Transfer {
    UsbToken token;
    std::uint64_t id = 0;
    usb_redir_bulk_packet_header header{};
    bool streamed = false;
  };
  /// Bytes that the parser hands over.
  class Received {
   public:
    Received(usbredirparser* parser, std::uint8_t* data, int size) : parser_(parser), data_(data), size_(size) {}
    ~Received() { usbredirparser_free_packet_data(parser_, data_); }
    Received(const Received&) = delete;
    Received& operator=(const Received&) = delete;
    [[nodiscard]] std::span<const std::byte> bytes() const {
      return std::as_bytes(std::span(data_, data_ == nullptr ? 0 : static_cast<std::size_t>(size_)));
    }

   private:
    usbredirparser* parser_;
    std::uint8_t* data_;
    int size_;
  };
  struct DestroyParser {
    void operator()(usbredirparser* parser) const { usbredirparser_destroy(parser); }
  };

  void SetTransport();
  void SetControlPackets();
  void SetDataPackets();
  void SetIgnoredPackets();
  static Device& From(void* self) { return *static_cast<Device*>(self); }
  int Read(std::uint8_t* data, int count);
  int Write(const std::uint8_t* data, int count);
  void TellConfiguration(std::uint64_t id, std::uint8_t configuration);
  void TellAlternate(std::uint64_t id, std::uint8_t interface, std::uint8_t alternate);
  void Control(std::uint64_t id, usb_redir_control_packet_header header, std::span<const std::byte> data);
  void Bulk(std::uint64_t id, usb_redir_bulk_packet_header header);
  void CancelBulk(std::uint64_t id);
  void StartReceiving(std::uint64_t id, const usb_redir_start_bulk_receiving_header& header);
  void StopReceiving(std::uint64_t id, const usb_redir_stop_bulk_receiving_header& header);
  void TellReceiving(std::uint64_t id, std::uint32_t stream, std::uint8_t endpoint, std::uint8_t status);
  bool Submit(std::uint64_t id, const usb_redir_bulk_packet_header& header, bool streamed);
  void Finish(UsbCompletion completion);
  /// Ends everything in flight without a word to the machine, and stops the board.
  void DropAll();

  UsbPort& board_;
  OwnedFd socket_;
  std::unique_ptr<usbredirparser, DestroyParser> parser_;
  std::vector<Transfer> transfers_;
  std::uint64_t streamed_packets_ = 0;
  std::uint64_t sent_bytes_ = 0;
  bool plugged_ = false;
  bool closed_ = false;
};

void Device::SetTransport() {
  parser_->log_func = [](void*, int level, const char* text) {
    if (level <= usbredirparser_error) Log(LogLevel::kWarning, text);
  };
  parser_->read_func = [](void* self, std::uint8_t* data, int count) { return From(self).Read(data, count); };
  parser_->write_func = [](void* self, std::uint8_t* data, int count) { return From(self).Write(data, count); };
}

void Device::SetControlPackets() {
  parser_->hello_func = [](void* self, usb_redir_hello_header*) { From(self).Plug(); };
  parser_->reset_func = [](void* self) { From(self).DropAll(); };
  parser_->set_configuration_func = [](void* self, std::uint64_t id, usb_redir_set_configuration_header* header) {
    From(self).TellConfiguration(id, header->configuration);
  };
  parser_->get_configuration_func = [](void* self, std::uint64_t id) { From(self).TellConfiguration(id, 1); };
  parser_->set_alt_setting_func = [](void* self, std::uint64_t id, usb_redir_set_alt_setting_header* header) {
    From(self).TellAlternate(id, header->interface, header->alt);
  };
  parser_->get_alt_setting_func = [](void* self, std::uint64_t id, usb_redir_get_alt_setting_header* header) {
    From(self).TellAlternate(id, header->interface, 0);
  };
  parser_->cancel_data_packet_func = [](void* self, std::uint64_t id) { From(self).CancelBulk(id); };
  parser_->start_bulk_receiving_func = [](void* self, std::uint64_t id, usb_redir_start_bulk_receiving_header* header) {
    From(self).StartReceiving(id, *header);
  };
  parser_->stop_bulk_receiving_func = [](void* self, std::uint64_t id, usb_redir_stop_bulk_receiving_header* header) {
    From(self).StopReceiving(id, *header);
  };
}

void Device::SetDataPackets() {
  parser_->control_packet_func = [](void* self, std::uint64_t id, usb_redir_control_packet_header* header,
                                    std::uint8_t* data, int size) {
    const Received received(From(self).parser_.get(), data, size);
    From(self).Control(id, *header, received.bytes());
  };
  parser_->bulk_packet_func = [](void* self, std::uint64_t id, usb_redir_bulk_packet_header* header, std::uint8_t* data,
                                 int size) {
    const Received received(From(self).parser_.get(), data, size);
    From(self).Bulk(id, *header);
  };
}

/// What a machine may send though a ring board has nothing of it. The parser calls without looking, so none may be
/// null.
void Device::SetIgnoredPackets() {
  parser_->start_iso_stream_func = [](void*, std::uint64_t, usb_redir_start_iso_stream_header*) {};
  parser_->stop_iso_stream_func = [](void*, std::uint64_t, usb_redir_stop_iso_stream_header*) {};
  parser_->start_interrupt_receiving_func = [](void*, std::uint64_t, usb_redir_start_interrupt_receiving_header*) {};
  parser_->stop_interrupt_receiving_func = [](void*, std::uint64_t, usb_redir_stop_interrupt_receiving_header*) {};
  parser_->alloc_bulk_streams_func = [](void*, std::uint64_t, usb_redir_alloc_bulk_streams_header*) {};
  parser_->free_bulk_streams_func = [](void*, std::uint64_t, usb_redir_free_bulk_streams_header*) {};
  parser_->filter_reject_func = [](void*) {};
  parser_->filter_filter_func = [](void*, usbredirfilter_rule* rules, int) { std::free(rules); };
  parser_->device_disconnect_ack_func = [](void*) {};
  parser_->iso_packet_func = [](void* self, std::uint64_t, usb_redir_iso_packet_header*, std::uint8_t* data, int size) {
    const Received received(From(self).parser_.get(), data, size);
  };
  parser_->interrupt_packet_func = [](void* self, std::uint64_t, usb_redir_interrupt_packet_header*, std::uint8_t* data,
                                      int size) { const Received received(From(self).parser_.get(), data, size); };
}

int Device::Read(std::uint8_t* data, int count) {
  const ssize_t size = ::recv(socket_.get(), data, static_cast<std::size_t>(count), MSG_DONTWAIT);
  if (size > 0) return static_cast<int>(size);
  if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return 0;
  closed_ = true;
  return -1;
}

int Device::Write(const std::uint8_t* data, int count) {
  const ssize_t size = ::send(socket_.get(), data, static_cast<std::size_t>(count), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (size >= 0) return static_cast<int>(size);
  if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR) return 0;
  closed_ = true;
  return -1;
}

Status Device::Serve() {
  const std::string attempted = "serve the board " + board_.identity().serial + " to the machine";
  if (usbredirparser_do_read(parser_.get()) == usbredirparser_read_parse_error) {
    return Fail(attempted, "bytes that are not usbredir", "connect the socket to a usb-redir device");
  }
  while (auto completion = board_.WaitCompletion(kLongAgo)) Finish(std::move(*completion));
  if (wants_to_write()) static_cast<void>(usbredirparser_do_write(parser_.get()));
  if (closed_) return Fail(attempted, "it closed the socket", "start the emulator again");
  return {};
}

void Device::Plug() {
  if (plugged_ || usbredirparser_have_peer_caps(parser_.get()) == 0) return;
  plugged_ = true;
  usb_redir_interface_info_header interfaces{};
  interfaces.interface_count = 1;
  interfaces.interface_class[0] = 0xFF;
  usbredirparser_send_interface_info(parser_.get(), &interfaces);
  usb_redir_ep_info_header endpoints{};
  std::fill(std::begin(endpoints.type), std::end(endpoints.type), std::uint8_t{usb_redir_type_invalid});
  endpoints.type[TableIndex(0x00)] = endpoints.type[TableIndex(0x80)] = usb_redir_type_control;
  endpoints.max_packet_size[TableIndex(0x00)] = endpoints.max_packet_size[TableIndex(0x80)] = 64;
  endpoints.type[TableIndex(kLevelEndpoint)] = usb_redir_type_bulk;
  endpoints.max_packet_size[TableIndex(kLevelEndpoint)] = kBulkPacketBytes;
  usbredirparser_send_ep_info(parser_.get(), &endpoints);
  usb_redir_device_connect_header device{};
  device.speed = usb_redir_speed_high;
  device.vendor_id = board_.identity().vendor_id;
  device.product_id = board_.identity().product_id;
  device.device_version_bcd = 0x0120;
  usbredirparser_send_device_connect(parser_.get(), &device);
}

void Device::Unplug() {
  if (!plugged_) return;
  plugged_ = false;
  DropAll();
  usbredirparser_send_device_disconnect(parser_.get());
}

void Device::DropAll() {
  static_cast<void>(board_.ControlOut({static_cast<std::uint8_t>(BoardRequest::kStop), 0, 0}, {}, kControlTimeout));
  for (const Transfer& transfer : transfers_) board_.Cancel(transfer.token);
  while (board_.WaitCompletion(kLongAgo)) {
  }
  transfers_.clear();
}

void Device::TellConfiguration(std::uint64_t id, std::uint8_t configuration) {
  usb_redir_configuration_status_header reply{};
  reply.status = configuration <= 1 ? usb_redir_success : usb_redir_stall;
  reply.configuration = 1;
  usbredirparser_send_configuration_status(parser_.get(), id, &reply);
}

void Device::TellAlternate(std::uint64_t id, std::uint8_t interface, std::uint8_t alternate) {
  usb_redir_alt_setting_status_header reply{};
  reply.status = interface == 0 && alternate == 0 ? usb_redir_success : usb_redir_stall;
  reply.interface = interface;
  usbredirparser_send_alt_setting_status(parser_.get(), id, &reply);
}

void Device::Control(std::uint64_t id, usb_redir_control_packet_header header, std::span<const std::byte> data) {
  if (!plugged_) return;
  const UsbSetup setup{header.requesttype, header.request, header.value, header.index, header.length};
  auto answer = AnswerSetup(board_, setup, data, kControlTimeout);
  std::vector<std::byte> reply = answer ? std::move(*answer) : std::vector<std::byte>{};
  header.status = WireStatus(answer ? UsbStatus::kCompleted : answer.error().status);
  const bool in = (header.requesttype & kDirectionIn) != 0;
  if (in) {
    reply.resize(std::min<std::size_t>(reply.size(), header.length));
    header.length = static_cast<std::uint16_t>(reply.size());
  }
  usbredirparser_send_control_packet(parser_.get(), id, &header,
                                     in ? reinterpret_cast<std::uint8_t*>(reply.data()) : nullptr,
                                     in ? static_cast<int>(reply.size()) : 0);
}

bool Device::Submit(std::uint64_t id, const usb_redir_bulk_packet_header& header, bool streamed) {
  const std::size_t length = static_cast<std::size_t>(header.length_high) << 16 | header.length;
  if (header.endpoint != kLevelEndpoint || length == 0 || length > kMostTransferBytes) return false;
  if (transfers_.size() >= kMostTransfers) return false;
  const auto token = board_.SubmitBulkIn(header.endpoint, length);
  if (token) transfers_.push_back({*token, id, header, streamed});
  return token.has_value();
}

void Device::Bulk(std::uint64_t id, usb_redir_bulk_packet_header header) {
  if (!plugged_) return;
  if (Submit(id, header, false)) return;
  header.length = header.length_high = 0;
  header.status = usb_redir_inval;
  usbredirparser_send_bulk_packet(parser_.get(), id, &header, nullptr, 0);
}

void Device::CancelBulk(std::uint64_t id) {
  for (const Transfer& transfer : transfers_) {
    if (!transfer.streamed && transfer.id == id) return board_.Cancel(transfer.token);
  }
}

void Device::StartReceiving(std::uint64_t id, const usb_redir_start_bulk_receiving_header& header) {
  usb_redir_bulk_packet_header each{};
  each.endpoint = header.endpoint;
  each.stream_id = header.stream_id;
  each.length = static_cast<std::uint16_t>(header.bytes_per_transfer & 0xFFFFU);
  each.length_high = static_cast<std::uint16_t>(header.bytes_per_transfer >> 16);
  bool good = header.bytes_per_transfer % kBulkPacketBytes == 0;
  for (int i = 0; i < header.no_transfers && good; ++i) good = Submit(id, each, true);
  TellReceiving(id, header.stream_id, header.endpoint, good ? usb_redir_success : usb_redir_inval);
}

void Device::StopReceiving(std::uint64_t id, const usb_redir_stop_bulk_receiving_header& header) {
  std::vector<UsbToken> stopped;
  for (const Transfer& transfer : transfers_) {
    if (transfer.streamed) stopped.push_back(transfer.token);
  }
  std::erase_if(transfers_, [](const Transfer& transfer) { return transfer.streamed; });
  for (const UsbToken token : stopped) board_.Cancel(token);
  TellReceiving(id, header.stream_id, header.endpoint, usb_redir_success);
}

void Device::TellReceiving(std::uint64_t id, std::uint32_t stream, std::uint8_t endpoint, std::uint8_t status) {
  usb_redir_bulk_receiving_status_header reply{};
  reply.stream_id = stream;
  reply.endpoint = endpoint;
  reply.status = status;
  usbredirparser_send_bulk_receiving_status(parser_.get(), id, &reply);
}

void Device::Finish(UsbCompletion completion) {
  const auto found = std::find_if(transfers_.begin(), transfers_.end(),
                                  [&](const Transfer& transfer) { return transfer.token == completion.token; });
  if (found == transfers_.end()) return;  // of a stream that was stopped
  const Transfer transfer = *found;
  transfers_.erase(found);
  sent_bytes_ += completion.data.size();
  const auto size = static_cast<int>(completion.data.size());
  auto* const data = reinterpret_cast<std::uint8_t*>(completion.data.data());
  if (transfer.streamed) {
    usb_redir_buffered_bulk_packet_header header{};
    header.endpoint = transfer.header.endpoint;
    header.stream_id = transfer.header.stream_id;
    header.status = WireStatus(completion.status);
    header.length = static_cast<std::uint32_t>(size);
    usbredirparser_send_buffered_bulk_packet(parser_.get(), streamed_packets_++, &header, data, size);
    static_cast<void>(Submit(transfer.id, transfer.header, true));
    return;
  }
  usb_redir_bulk_packet_header header = transfer.header;
  header.status = WireStatus(completion.status);
  header.length = static_cast<std::uint16_t>(completion.data.size() & 0xFFFFU);
  header.length_high = static_cast<std::uint16_t>(completion.data.size() >> 16);
  usbredirparser_send_bulk_packet(parser_.get(), transfer.id, &header, data, size);
}

}  // namespace

std::unique_ptr<UsbredirDevice> MakeUsbredirDevice(UsbPort& board, OwnedFd socket) {
  return std::make_unique<Device>(board, std::move(socket));
}

Status ServeUsbredir(const std::vector<UsbredirDevice*>& devices, Clock& clock, nanoseconds deadline) {
  std::vector<pollfd> ready(devices.size());
  while (true) {
    bool reading = false;
    for (UsbredirDevice* device : devices) {
      RETURN_IF_ERROR(device->Serve());
      reading = reading || device->in_flight() > 0;
    }
    const nanoseconds now = clock.Now();
    if (now >= deadline) return {};
    for (std::size_t i = 0; i < devices.size(); ++i) {
      const int events = devices[i]->wants_to_write() ? POLLIN | POLLOUT : POLLIN;
      ready[i] = {devices[i]->socket(), static_cast<short>(events), 0};
    }
    const auto wait = std::chrono::ceil<milliseconds>(std::min(deadline - now, reading ? kPoll : kIdlePoll));
    static_cast<void>(::poll(ready.data(), ready.size(), static_cast<int>(wait.count())));
  }
}

}  // namespace annulus::sim
