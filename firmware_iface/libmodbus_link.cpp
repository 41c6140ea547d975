#include <arpa/inet.h>
#include <fcntl.h>
#include <modbus.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "base/ensure.h"
#include "firmware_iface/modbus_link.h"

namespace annulus {
namespace {

using std::chrono::nanoseconds;

constexpr const char* kSerialFolder = "/dev/serial/by-id";

/// A descriptor that is closed once. `reset` says how: sockets so that the peer gets RST and nothing that is queued.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    if (this != &other) {
      Close();
      fd_ = std::exchange(other.fd_, -1);
    }
    return *this;
  }
  ~Descriptor() { Close(); }

  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] bool open() const { return fd_ >= 0; }
  void Close() {
    if (fd_ < 0) return;
    // Each does nothing on the other kind of descriptor. Without the flush, closing a serial port waits until all
    // is sent, which a stopped line never is.
    const linger reset{1, 0};
    static_cast<void>(::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &reset, sizeof(reset)));
    static_cast<void>(::tcflush(fd_, TCIOFLUSH));
    ::close(fd_);
    fd_ = -1;
  }
  /// Closes it without a word to the device, which is somebody else's.
  void Leave() {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  }

 private:
  int fd_ = -1;
};

struct ContextDeleter {
  void operator()(modbus_t* context) const { modbus_free(context); }  // leaves the descriptor alone
};
using Context = std::unique_ptr<modbus_t, ContextDeleter>;

ModbusFailure Failure(int error) {
  ModbusFailure failure{ModbusFault::kLinkLost, 0, modbus_strerror(error)};
  if (error > MODBUS_ENOBASE && error < MODBUS_ENOBASE + MODBUS_EXCEPTION_MAX) {
    failure.fault = ModbusFault::kException;
    failure.exception_code = static_cast<std::uint8_t>(error - MODBUS_ENOBASE);
    failure.detail.clear();
  } else if (error >= MODBUS_ENOBASE) {
    failure.fault = ModbusFault::kBadReply;
  } else if (error == ETIMEDOUT || error == EAGAIN || error == EWOULDBLOCK) {
    // A full send buffer (EAGAIN) is a peer that does not read: just as silent.
    failure.fault = ModbusFault::kTimeout;
    failure.detail.clear();
  }
  return failure;
}

using Opened = tl::expected<Descriptor, ModbusFailure>;

Opened LinkLost(std::string detail) {
  return tl::unexpected<ModbusFailure>(ModbusFailure{ModbusFault::kLinkLost, 0, std::move(detail)});
}

/// libmodbus waits by select(), which corrupts memory for descriptors of 1024 and more.
Opened Selectable(Descriptor descriptor) {
  if (descriptor.get() < FD_SETSIZE) return descriptor;
  return LinkLost("descriptor " + std::to_string(descriptor.get()) +
                  " of the axis link is beyond select()'s limit of " + std::to_string(FD_SETSIZE) +
                  "; too many files are open");
}

/// One Modbus device behind libmodbus. Its recovery stays off: it would send requests again by itself.
class LibmodbusLink final : public ModbusLink {
 public:
  /// `open` opens the port or connection anew.
  LibmodbusLink(Context context, std::function<Opened()> open, std::optional<ModbusRtuOptions> serial = std::nullopt)
      : context_(std::move(context)), open_(std::move(open)), serial_(std::move(serial)) {
    static_cast<void>(modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE));
    // No time-out between bytes: so the time-out of the reply holds for the whole of it (select() counts it down).
    static_cast<void>(modbus_set_byte_timeout(context_.get(), 0, 0));
  }

  ModbusReply Transact(const ModbusRequest& request, nanoseconds timeout) override;
  [[nodiscard]] nanoseconds WireTime(const ModbusRequest& request) const override {
    return serial_ ? ModbusRtuWireTime(*serial_, request) : nanoseconds(0);
  }
  void DiscardInput() override {
    if (descriptor_.open()) static_cast<void>(modbus_flush(context_.get()));
  }
  void Close() override {
    static_cast<void>(modbus_set_socket(context_.get(), -1));
    descriptor_.Close();
  }
  tl::expected<void, ModbusFailure> Reopen() override;

 private:
  int Call(const ModbusRequest& request, std::vector<std::uint16_t>& read);

  Context context_;
  std::function<Opened()> open_;
  std::optional<ModbusRtuOptions> serial_;  ///< Nothing: no serial line.
  Descriptor descriptor_;
};

tl::expected<void, ModbusFailure> LibmodbusLink::Reopen() {
  Close();
  Opened opened = open_();
  if (opened) opened = Selectable(std::move(*opened));
  if (!opened) return tl::unexpected<ModbusFailure>(opened.error());
  descriptor_ = std::move(*opened);
  static_cast<void>(modbus_set_socket(context_.get(), descriptor_.get()));
  return {};
}

int LibmodbusLink::Call(const ModbusRequest& request, std::vector<std::uint16_t>& read) {
  const int count = static_cast<int>(request.values.size());
  const bool writes = request.function != ModbusFunction::kReadRegisters;
  const bool reads = !writes || request.function == ModbusFunction::kWriteReadRegisters;
  ENSURE(!reads || (request.read_count > 0 && request.read_count <= MODBUS_MAX_READ_REGISTERS),
         "a transaction reads 1 to 125 registers");
  ENSURE(!writes || (count > 0 && count <= MODBUS_MAX_WR_WRITE_REGISTERS), "a transaction writes 1 to 121 registers");
  if (reads) read.resize(request.read_count);
  switch (request.function) {
    case ModbusFunction::kReadRegisters:
      return modbus_read_registers(context_.get(), request.read_address, request.read_count, read.data());
    case ModbusFunction::kWriteRegister:
      return modbus_write_register(context_.get(), request.write_address, request.values.front());
    case ModbusFunction::kWriteRegisters:
      return modbus_write_registers(context_.get(), request.write_address, count, request.values.data());
    case ModbusFunction::kWriteReadRegisters:
      return modbus_write_and_read_registers(context_.get(), request.write_address, count, request.values.data(),
                                             request.read_address, request.read_count, read.data());
  }
  errno = EINVAL;
  return -1;
}

ModbusReply LibmodbusLink::Transact(const ModbusRequest& request, nanoseconds timeout) {
  if (!descriptor_.open()) {
    return tl::unexpected<ModbusFailure>(ModbusFailure{ModbusFault::kLinkLost, 0, "it is closed"});
  }
  // libmodbus refuses a time-out of 0.
  const auto us = std::max<std::int64_t>(1, std::chrono::ceil<std::chrono::microseconds>(timeout).count());
  static_cast<void>(modbus_set_response_timeout(context_.get(), static_cast<std::uint32_t>(us / 1'000'000),
                                                static_cast<std::uint32_t>(us % 1'000'000)));
  std::vector<std::uint16_t> read;
  errno = 0;
  if (Call(request, read) >= 0) return read;
  ModbusFailure failure = Failure(errno);
  if (failure.fault == ModbusFault::kLinkLost) Close();
  return tl::unexpected<ModbusFailure>(std::move(failure));
}

// --- serial ports ---

/// A context of the serial port that does not own its descriptor yet.
Context RtuContext(const ModbusRtuOptions& options) {
  Context context(
      modbus_new_rtu(options.device.c_str(), options.baud, options.parity, /*data_bit=*/8, options.stop_bits));
  if (context != nullptr && modbus_set_slave(context.get(), options.unit) != 0) context.reset();
  return context;
}

/// What the name stands for at the moment: by-id names are links.
std::string RealName(const std::string& device) {
  std::error_code ignored;
  const auto real = std::filesystem::canonical(device, ignored);
  return ignored || real == device ? device : device + " (" + real.string() + ")";
}

Opened OpenSerial(const ModbusRtuOptions& options) {
  const auto lost = [&options](int error) {
    const std::string what = RealName(options.device) + ": " + modbus_strerror(error);
    if (error == EBUSY) return LinkLost(what + ", another program has it");
    if (error == EINVAL) return LinkLost(what + ", it does not take parity or baud rate (a pseudo-terminal: parity N)");
    return LinkLost(what);
  };
  Descriptor port(::open(options.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!port.open()) return lost(errno);
  // The lock belongs to the port, not to the name: two names of one port meet here. Nothing touches the line before we
  // have it: settings and buffers are the port's, too, and whoever has the lock is talking.
  if (::flock(port.get(), LOCK_EX | LOCK_NB) != 0) {
    port.Leave();
    return LinkLost(RealName(options.device) + " is in use already, perhaps under another name");
  }
  // libmodbus opens the port once more and sets the line; what it has set holds for our descriptor as well.
  const Context context = RtuContext(options);
  if (context == nullptr) return LinkLost("libmodbus takes none of these settings");
  if (modbus_connect(context.get()) != 0) return lost(errno);
  Descriptor(modbus_get_socket(context.get())).Leave();
  static_cast<void>(modbus_set_socket(context.get(), -1));
  return port;
}

Status CheckRtu(const std::string& attempted, const ModbusRtuOptions& options) {
  constexpr std::array<int, 10> kBauds{1200, 2400, 4800, 9600, 19'200, 38'400, 57'600, 115'200, 460'800, 921'600};
  const char* advice = "correct [axis] in the configuration";
  if (options.device.empty()) return Fail(attempted, "no device is named", advice);
  if (std::find(kBauds.begin(), kBauds.end(), options.baud) == kBauds.end() && options.baud != 230'400) {
    return Fail(attempted, "a serial line does not run at " + std::to_string(options.baud) + " baud", advice);
  }
  if (options.parity != 'N' && options.parity != 'E' && options.parity != 'O') {
    return Fail(attempted, std::string("parity '") + options.parity + "' is none of N, E, O", advice);
  }
  if (options.stop_bits != 1 && options.stop_bits != 2) {
    return Fail(attempted, std::to_string(options.stop_bits) + " stop bits are neither 1 nor 2", advice);
  }
  if (options.unit < 1 || options.unit > 247) {
    return Fail(attempted, "unit " + std::to_string(options.unit) + " is not in 1 to 247", advice);
  }
  return {};
}

// --- connections ---

struct AddressListDeleter {
  void operator()(addrinfo* list) const { ::freeaddrinfo(list); }
};

Opened Connect(const ModbusTcpOptions& options, Clock& clock) {
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int code = ::getaddrinfo(options.host.c_str(), std::to_string(options.port).c_str(), &hints, &found);
  const std::unique_ptr<addrinfo, AddressListDeleter> address(found);
  if (code != 0 || address == nullptr) return LinkLost("'" + options.host + "' is not an address in digits");
  // libmodbus' own way to connect waits by select() before anybody can look at the descriptor.
  Opened opened = Selectable(
      Descriptor(::socket(address->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, address->ai_protocol)));
  if (!opened) return opened;
  if (!opened->open()) return LinkLost(std::strerror(errno));
  const int on = 1;
  const int off = 0;
  // A request must leave at once; and a silent peer is found by our time-outs, not by the kernel's in two hours.
  static_cast<void>(::setsockopt(opened->get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on)));
  static_cast<void>(::setsockopt(opened->get(), SOL_SOCKET, SO_KEEPALIVE, &off, sizeof(off)));
  if (::connect(opened->get(), address->ai_addr, address->ai_addrlen) == 0) return opened;
  if (errno != EINPROGRESS) return LinkLost(std::strerror(errno));
  const nanoseconds deadline = clock.Now() + options.connect_timeout;
  pollfd waiting{opened->get(), POLLOUT, 0};
  int ready = -1;
  do {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - clock.Now()).count();
    ready = ::poll(&waiting, 1, static_cast<int>(std::clamp<std::int64_t>(left, 0, 60'000)));
  } while (ready < 0 && errno == EINTR);
  if (ready == 0) return LinkLost("no answer in time");
  int error = 0;
  socklen_t size = sizeof(error);
  static_cast<void>(::getsockopt(opened->get(), SOL_SOCKET, SO_ERROR, &error, &size));
  if (ready < 0 || error != 0) return LinkLost(std::strerror(ready < 0 ? errno : error));
  return opened;
}

/// A TCP context; it connects nowhere by itself.
Context TcpContext(int unit) {
  Context context(modbus_new_tcp("127.0.0.1", MODBUS_TCP_DEFAULT_PORT));
  // Units above 247 are for TCP gateways; libmodbus knows one of them.
  if (context != nullptr && modbus_set_slave(context.get(), unit) != 0) context.reset();
  return context;
}

}  // namespace

Result<std::unique_ptr<ModbusLink>> OpenModbusRtu(const ModbusRtuOptions& options, Clock& /*clock*/) {
  const std::string attempted = "open the axis' serial port " + options.device;
  RETURN_IF_ERROR(CheckRtu(attempted, options));
  Context context = RtuContext(options);
  if (context == nullptr) return Fail(attempted, std::strerror(errno), "correct [axis] in the configuration");
  auto link = std::make_unique<LibmodbusLink>(
      std::move(context), [options] { return OpenSerial(options); }, options);
  if (const auto opened = link->Reopen(); !opened) {
    return Fail(attempted, opened.error().detail,
                "check the adapter and its name under " + std::string(kSerialFolder) +
                    ", and that you may open it (group dialout)");
  }
  return link;
}

Result<std::unique_ptr<ModbusLink>> OpenModbusTcp(const ModbusTcpOptions& options, Clock& clock) {
  const std::string attempted =
      "connect to the axis drive at " + options.host + " port " + std::to_string(options.port);
  const char* advice = "correct [axis] in the configuration";
  if (options.port < 1 || options.port > 65'535) return Fail(attempted, "a port is 1 to 65535", advice);
  Context context = TcpContext(options.unit);
  if (context == nullptr) {
    return Fail(attempted, "unit " + std::to_string(options.unit) + " is neither in 0 to 247 nor 255", advice);
  }
  auto link =
      std::make_unique<LibmodbusLink>(std::move(context), [options, &clock] { return Connect(options, clock); });
  if (const auto opened = link->Reopen(); !opened) {
    return Fail(attempted, opened.error().detail, "check the drive's supply, cable and address");
  }
  return link;
}

Result<std::unique_ptr<ModbusLink>> AdoptModbusDescriptor(int fd, ModbusFraming framing, int unit) {
  const char* attempted = "speak Modbus over an open descriptor";
  // Opened once: the second time there is nothing to open.
  auto adopted = std::make_shared<Descriptor>(fd);  // shared: std::function wants to be copyable
  Context context = framing == ModbusFraming::kTcp
                        ? TcpContext(unit)
                        : RtuContext({"adopted", 115'200, /*parity=*/'N', /*stop_bits=*/1, unit});
  if (context == nullptr) return Fail(attempted, "unit " + std::to_string(unit) + " makes no sense", "choose 1 to 247");
  auto link = std::make_unique<LibmodbusLink>(std::move(context), [adopted]() -> Opened {
    if (!adopted->open()) return LinkLost("a descriptor without a name can not be opened again");
    return std::move(*adopted);
  });
  if (const auto opened = link->Reopen(); !opened) return Fail(attempted, opened.error().detail, "close other files");
  return link;
}

std::vector<std::string> ListSerialPorts() {
  std::vector<std::string> ports;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(kSerialFolder, ignored)) {
    ports.push_back(entry.path().string());
  }
  std::sort(ports.begin(), ports.end());
  return ports;
}

}  // namespace annulus
