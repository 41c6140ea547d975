#include "sim/modbus_server.h"

#include <fcntl.h>
#include <modbus.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace annulus::sim {
namespace {

constexpr int kPollMs = 10;  ///< How often the thread looks whether it shall end.
constexpr std::size_t kMostClients = 16;
constexpr std::uint32_t kByteTimeoutUs = 20'000;  ///< Within a request.
constexpr std::uint32_t kErrorPauseUs = 1'000;    ///< libmodbus waits that long after a request that makes no sense.
constexpr std::chrono::seconds kDevicePatience{1};
constexpr std::uint8_t kIllegalFunction = 1;

class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_ = -1;
};

struct ContextDeleter {
  void operator()(modbus_t* context) const { modbus_free(context); }  // leaves the descriptor alone
};
struct MappingDeleter {
  void operator()(modbus_mapping_t* mapping) const { modbus_mapping_free(mapping); }
};
using Context = std::unique_ptr<modbus_t, ContextDeleter>;
using Mapping = std::unique_ptr<modbus_mapping_t, MappingDeleter>;

Context Prepared(Context context, int unit) {
  if (context == nullptr || modbus_set_slave(context.get(), unit) != 0) return nullptr;
  static_cast<void>(modbus_set_byte_timeout(context.get(), 0, kByteTimeoutUs));
  static_cast<void>(modbus_set_indication_timeout(context.get(), 0, kByteTimeoutUs));
  static_cast<void>(modbus_set_response_timeout(context.get(), 0, kErrorPauseUs));
  return context;
}

Context RtuContext(int unit) {
  // Never connected: the descriptor is the terminal's other end.
  return Prepared(Context(modbus_new_rtu("/dev/ptmx", 115'200, 'N', 8, 1)), unit);
}

Context TcpContext(int port) { return Prepared(Context(modbus_new_tcp("127.0.0.1", port)), MODBUS_TCP_SLAVE); }

tl::unexpected<Error> SystemFailure(const char* attempted) {
  return Fail(attempted, std::strerror(errno), "choose another port or name");
}

/// A request's fields, big-endian; the lengths are those that libmodbus has checked.
class RequestBytes {
 public:
  RequestBytes(const std::uint8_t* pdu, std::size_t size) : pdu_(pdu), size_(size) {}
  [[nodiscard]] std::uint8_t function() const { return pdu_[0]; }
  [[nodiscard]] std::uint16_t Word(std::size_t offset) const {
    if (offset + 1 >= size_) return 0;
    return static_cast<std::uint16_t>(pdu_[offset] << 8 | pdu_[offset + 1]);
  }
  [[nodiscard]] std::vector<std::uint16_t> Words(std::size_t offset, std::size_t count) const {
    std::vector<std::uint16_t> words;
    for (std::size_t i = 0; i < count; ++i) words.push_back(Word(offset + 2 * i));
    return words;
  }
  /// Whether the byte at `offset` tells twice `count`.
  [[nodiscard]] bool Tells(std::size_t offset, std::size_t count) const {
    return offset < size_ && pdu_[offset] == 2 * count;
  }

 private:
  const std::uint8_t* pdu_;
  std::size_t size_;
};

/// The request for the model; nothing if it is another function's, or its counts are wrong.
std::optional<ModbusRequest> Parse(const RequestBytes& bytes) {
  const auto counts = [](std::size_t count, std::size_t most) { return count > 0 && count <= most; };
  switch (bytes.function()) {
    case MODBUS_FC_READ_HOLDING_REGISTERS:
      if (!counts(bytes.Word(3), MODBUS_MAX_READ_REGISTERS)) return std::nullopt;
      return ModbusRequest{ModbusFunction::kReadRegisters, 0, {}, bytes.Word(1), bytes.Word(3)};
    case MODBUS_FC_WRITE_SINGLE_REGISTER:
      return ModbusRequest{ModbusFunction::kWriteRegister, bytes.Word(1), {bytes.Word(3)}, 0, 0};
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS: {
      const std::size_t count = bytes.Word(3);
      if (!counts(count, MODBUS_MAX_WRITE_REGISTERS) || !bytes.Tells(5, count)) return std::nullopt;
      return ModbusRequest{ModbusFunction::kWriteRegisters, bytes.Word(1), bytes.Words(6, count), 0, 0};
    }
    case MODBUS_FC_WRITE_AND_READ_REGISTERS: {
      const std::size_t count = bytes.Word(7);
      if (!counts(bytes.Word(3), MODBUS_MAX_WR_READ_REGISTERS) || !counts(count, MODBUS_MAX_WR_WRITE_REGISTERS) ||
          !bytes.Tells(9, count)) {
        return std::nullopt;
      }
      return ModbusRequest{ModbusFunction::kWriteReadRegisters, bytes.Word(5), bytes.Words(10, count), bytes.Word(1),
                           bytes.Word(3)};
    }
    default:
      return std::nullopt;
  }
}

}  // namespace

class ModbusServer::Impl {
 public:
  Impl(ModbusLink& device, ModbusServerOptions options)
      : device_(device), options_(std::move(options)), mapping_(modbus_mapping_new(0, 0, /*nb_registers=*/65'536, 0)) {}
  ~Impl() {
    thread_ = {};  // stopped and joined before anything else goes
    std::error_code ignored;
    // Unless somebody else has taken the name.
    if (linked_ && std::filesystem::read_symlink(options_.symlink, ignored) == terminal_) {
      std::filesystem::remove(options_.symlink, ignored);
    }
  }

  Status Open() {
    if (mapping_ == nullptr) return SystemFailure("make room for registers");
    RETURN_IF_ERROR(options_.tcp_port ? Listen() : OpenTerminal());
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
    return {};
  }

  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] const std::string& device_name() const { return device_name_; }
  void Inspect(const std::function<void()>& look) {
    const std::lock_guard lock(mutex_);
    look();
  }
  void Stall(bool stalled) { stalled_ = stalled; }

 private:
  Status Listen();
  Status OpenTerminal();
  Status LinkTerminal(const std::string& terminal);
  void Run(const std::stop_token& stop);
  void Accept();
  /// One request of one peer. False: the connection is of no more use.
  bool Serve(int fd);
  bool Answer(const std::uint8_t* request, int length);
  ModbusReply Carry(const ModbusRequest& request) {
    const std::lock_guard lock(mutex_);
    return device_.Transact(request, kDevicePatience);
  }

  ModbusLink& device_;
  ModbusServerOptions options_;
  Mapping mapping_;
  Context context_;
  int port_ = 0;
  std::string device_name_;
  bool linked_ = false;
  std::filesystem::path terminal_;
  Descriptor listener_;  ///< Or the terminal's master.
  Descriptor kept_;      ///< RTU: the slave side, so that a master that leaves does not end the terminal.
  std::vector<Descriptor> clients_;
  std::atomic<bool> stalled_ = false;
  std::mutex mutex_;  ///< Guards device_.
  std::jthread thread_;
};

Status ModbusServer::Impl::Listen() {
  const char* attempted = "serve Modbus TCP on 127.0.0.1";
  context_ = TcpContext(*options_.tcp_port);
  if (context_ == nullptr) return SystemFailure(attempted);
  listener_ = Descriptor(modbus_tcp_listen(context_.get(), static_cast<int>(kMostClients)));
  if (listener_.get() < 0) return SystemFailure(attempted);
  sockaddr_in address{};
  socklen_t size = sizeof(address);
  if (::getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    return SystemFailure(attempted);
  }
  port_ = ntohs(address.sin_port);
  return {};
}

Status ModbusServer::Impl::OpenTerminal() {
  const char* attempted = "serve Modbus RTU on a pseudo-terminal";
  context_ = RtuContext(options_.unit);
  if (context_ == nullptr) return SystemFailure(attempted);
  listener_ = Descriptor(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK));
  std::array<char, 64> name{};
  if (listener_.get() < 0 || ::grantpt(listener_.get()) != 0 || ::unlockpt(listener_.get()) != 0 ||
      ::ptsname_r(listener_.get(), name.data(), name.size()) != 0) {
    return SystemFailure(attempted);
  }
  kept_ = Descriptor(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios line{};
  if (kept_.get() < 0 || ::tcgetattr(kept_.get(), &line) != 0) return SystemFailure(attempted);
  ::cfmakeraw(&line);
  if (::tcsetattr(kept_.get(), TCSANOW, &line) != 0) return SystemFailure(attempted);
  return LinkTerminal(name.data());
}

Status ModbusServer::Impl::LinkTerminal(const std::string& terminal) {
  device_name_ = terminal;
  if (options_.symlink.empty()) return {};
  std::error_code error;
  // Only what an earlier server left: a link to a terminal that is gone.
  const bool stale = std::filesystem::is_symlink(options_.symlink, error) &&
                     std::filesystem::read_symlink(options_.symlink, error).string().starts_with("/dev/pts/") &&
                     !std::filesystem::exists(options_.symlink, error);
  if (stale) std::filesystem::remove(options_.symlink, error);
  std::filesystem::create_symlink(terminal, options_.symlink, error);
  if (error) return Fail("name the terminal " + options_.symlink, error.message(), "choose another name");
  linked_ = true;
  terminal_ = terminal;
  device_name_ = options_.symlink;
  return {};
}

void ModbusServer::Impl::Run(const std::stop_token& stop) {
  const bool tcp = options_.tcp_port.has_value();
  while (!stop.stop_requested()) {
    std::vector<pollfd> waiting;
    waiting.push_back({listener_.get(), POLLIN, 0});
    for (const Descriptor& client : clients_) waiting.push_back({client.get(), POLLIN, 0});
    if (stalled_) waiting.resize(tcp ? 1 : 0);
    if (::poll(waiting.data(), waiting.size(), kPollMs) <= 0) continue;
    // A request that came after Stall is left unread, though the waiting for it began before.
    const bool stalled = stalled_;
    for (std::size_t i = waiting.size(); i-- > 1;) {
      if (stalled || waiting[i].revents == 0 || Serve(waiting[i].fd)) continue;
      clients_.erase(clients_.begin() + static_cast<std::ptrdiff_t>(i - 1));
    }
    if (waiting.empty() || (waiting[0].revents & POLLIN) == 0) continue;
    if (tcp) {
      Accept();
    } else if (!stalled) {
      static_cast<void>(Serve(listener_.get()));
    }
  }
}

void ModbusServer::Impl::Accept() {
  Descriptor client(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  // libmodbus can not wait for descriptors beyond select()'s limit.
  if (client.get() < 0 || client.get() >= FD_SETSIZE || clients_.size() >= kMostClients) return;
  const int on = 1;
  static_cast<void>(::setsockopt(client.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on)));
  clients_.push_back(std::move(client));
}

bool ModbusServer::Impl::Serve(int fd) {
  static_cast<void>(modbus_set_socket(context_.get(), fd));
  std::array<std::uint8_t, MODBUS_MAX_ADU_LENGTH> request{};
  const int length = modbus_receive(context_.get(), request.data());
  if (length > 0) return Answer(request.data(), length);
  if (options_.tcp_port) return false;
  if (length == 0) {
    // For another unit. libmodbus now takes the next request for that unit's reply; a fresh context does not.
    context_ = RtuContext(options_.unit);
    return true;
  }
  std::array<std::uint8_t, 256> rest{};
  while (::read(fd, rest.data(), rest.size()) > 0) {
  }
  return true;
}

bool ModbusServer::Impl::Answer(const std::uint8_t* request, int length) {
  const int header = modbus_get_header_length(context_.get());
  const RequestBytes bytes(request + header, static_cast<std::size_t>(length - header));
  constexpr std::array<int, 4> kOurs{MODBUS_FC_READ_HOLDING_REGISTERS, MODBUS_FC_WRITE_SINGLE_REGISTER,
                                     MODBUS_FC_WRITE_MULTIPLE_REGISTERS, MODBUS_FC_WRITE_AND_READ_REGISTERS};
  if (std::find(kOurs.begin(), kOurs.end(), bytes.function()) == kOurs.end()) {
    return modbus_reply_exception(context_.get(), request, kIllegalFunction) >= 0;
  }
  if (const auto parsed = Parse(bytes)) {
    // The model first, which writes before it reads; then libmodbus, which copies what the mapping holds.
    const ModbusReply reply = Carry(*parsed);
    if (!reply && reply.error().fault != ModbusFault::kException) return true;  // silence
    if (!reply) return modbus_reply_exception(context_.get(), request, reply.error().exception_code) >= 0;
    std::copy(reply->begin(), reply->end(), mapping_->tab_registers + parsed->read_address);
  }
  return modbus_reply(context_.get(), request, length, mapping_.get()) >= 0;
}

ModbusServer::ModbusServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ModbusServer::~ModbusServer() = default;

Result<std::unique_ptr<ModbusServer>> ModbusServer::Start(ModbusLink& device, ModbusServerOptions options) {
  auto impl = std::make_unique<Impl>(device, std::move(options));
  RETURN_IF_ERROR(impl->Open());
  return std::unique_ptr<ModbusServer>(new ModbusServer(std::move(impl)));
}

int ModbusServer::port() const { return impl_->port(); }
const std::string& ModbusServer::device_name() const { return impl_->device_name(); }
void ModbusServer::Inspect(const std::function<void()>& look) { impl_->Inspect(look); }
void ModbusServer::Stall() { impl_->Stall(true); }
void ModbusServer::Resume() { impl_->Stall(false); }

}  // namespace annulus::sim
