#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "acquisition/scan_machine.h"
#include "base/clock.h"
#include "station/booth_client.h"
#include "station/booth_server.h"

namespace annulus::test {

inline constexpr std::chrono::seconds kSoon{10};

/// A folder of its own, removed at the end.
class FreshFolder {
 public:
  FreshFolder() {
    static std::atomic<int> count{0};
    path_ = std::filesystem::temp_directory_path() /
            ("annulus_booth_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~FreshFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  FreshFolder(const FreshFolder&) = delete;
  FreshFolder& operator=(const FreshFolder&) = delete;
  [[nodiscard]] std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// The booth's own state machine behind the port, without devices: what they would tell it, the test does.
class MachinePort final : public BoothPort {
 public:
  MachinePort() {
    description_.station_id = "test";
    description_.program_version = "1.2.3";
    description_.simulated = true;
    description_.ring_radius_mm = 600.0;
    description_.boards = {{1001, 0, 15, "2.0.1"}, {1002, 15, 15, "2.0.1"}};
    description_.axis.z_min = Millimetres(-60.0);
    description_.axis.z_max = Millimetres(2250.0);
    description_.profiles = {"body", "head"};
  }

  [[nodiscard]] const BoothDescription& description() const override { return description_; }
  Status Home() override { return Order(ScanEventKind::kHomeOrdered); }
  Status Arm(const ArmOrder& order) override {
    const Status armed = Order(ScanEventKind::kArmed);
    const std::lock_guard lock(mutex_);
    if (armed) armed_ = order;
    return armed;
  }
  Status Start(std::uint64_t version) override {
    ScanEvent event = EventOf(ScanEventKind::kStarted);
    event.version = version;
    event.longest = std::chrono::hours(1);
    return Tell(event);
  }
  Status Cancel() override { return Order(ScanEventKind::kCancelled); }
  Status Acknowledge(CauseRole role) override {
    ScanEvent event = EventOf(ScanEventKind::kAcknowledged);
    event.role = role;
    return Tell(event);
  }
  Status Jog(Scanner::JogDirection direction) override {
    direction_ = direction;
    return Order(ScanEventKind::kJogOrdered);
  }
  [[nodiscard]] ScannerStatus status() const override {
    const std::lock_guard lock(mutex_);
    ScannerStatus status = status_;
    status.state = machine_.state();
    status.version = machine_.version();
    status.homed = machine_.homed();
    status.causes = machine_.causes();
    return status;
  }

  /// What the devices would say.
  Status Tell(const ScanEvent& event) {
    const std::lock_guard lock(mutex_);
    return machine_.Handle(event);
  }
  Status Tell(ScanEventKind kind) { return Tell(EventOf(kind)); }
  void Fault(const ScanCause& cause) {
    ScanEvent event = EventOf(ScanEventKind::kFaulted);
    event.cause = cause;
    ASSERT_TRUE(Tell(event));
  }
  /// Changes the rest of the status.
  void Change(const std::function<void(ScannerStatus&)>& change) {
    const std::lock_guard lock(mutex_);
    change(status_);
  }
  [[nodiscard]] std::uint64_t scans() const {
    const std::lock_guard lock(mutex_);
    return machine_.scans();
  }
  [[nodiscard]] ArmOrder armed() const {
    const std::lock_guard lock(mutex_);
    return armed_;
  }

 private:
  [[nodiscard]] ScanEvent EventOf(ScanEventKind kind) const {
    ScanEvent event;
    event.kind = kind;
    event.time = SystemClock().Now();
    return event;
  }
  Status Order(ScanEventKind kind) { return Tell(EventOf(kind)); }

  BoothDescription description_;
  mutable std::mutex mutex_;
  ScanMachine machine_;
  ScannerStatus status_;
  ArmOrder armed_;
  std::atomic<Scanner::JogDirection> direction_{Scanner::JogDirection::kUp};
};

/// A served booth, in IDLE.
class ServedBooth {
 public:
  ServedBooth() : levels_(std::move(*LevelMailbox::Make())) {
    auto socket = BoothSocket::Listen(path());
    if (!socket) throw std::runtime_error(socket.error().Text());
    auto server = BoothServer::Make(std::move(*socket), port_, *levels_);
    if (!server) throw std::runtime_error(server.error().Text());
    server_ = std::move(*server);
    EXPECT_TRUE(port_.Tell(ScanEventKind::kResetTaken));
    thread_ = std::jthread([this](const std::stop_token& stop) { server_->Serve(stop); });
  }
  /// Asks the server to end, and waits for it.
  void End() {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
    server_.reset();
  }
  ~ServedBooth() { End(); }
  ServedBooth(const ServedBooth&) = delete;
  ServedBooth& operator=(const ServedBooth&) = delete;

  [[nodiscard]] std::string path() const { return folder_ / "booth.sock"; }
  MachinePort& port() { return port_; }
  LevelMailbox& levels() { return *levels_; }

  [[nodiscard]] Result<BoothClient> TryConnect(const HelloOrder& hello) const {
    return BoothClient::Connect(path(), hello, kSoon);
  }
  [[nodiscard]] BoothClient Connect(const HelloOrder& hello) const {
    auto client = TryConnect(hello);
    if (!client) throw std::runtime_error(client.error().Text());
    return std::move(*client);
  }
  [[nodiscard]] BoothClient Viewer() const { return Connect({BoothRole::kOperator, false, "viewer"}); }
  [[nodiscard]] BoothClient Operator() const { return Connect({BoothRole::kOperator, true, "operator"}); }
  [[nodiscard]] BoothClient Technician() const { return Connect({BoothRole::kTechnician, true, "technician"}); }
  /// A connection that has said nothing.
  [[nodiscard]] sim::OwnedFd Raw() const {
    auto fd = sim::ConnectUnixSocket(path(), SystemClock().Now() + kSoon);
    EXPECT_TRUE(fd) << fd.error().Text();
    return std::move(*fd);
  }

 private:
  FreshFolder folder_;
  MachinePort port_;
  std::unique_ptr<LevelMailbox> levels_;
  std::unique_ptr<BoothServer> server_;
  std::jthread thread_;
};

inline auto InState(ScanState state) {
  return [state](const StatusMessage& message) { return message.scanner.state == state; };
}

/// All of the text, framed, to a raw connection; false when it is closed.
inline bool SendRaw(const sim::OwnedFd& fd, const std::string& json) {
  const std::string frame = *BoothFrame(json);
  return ::send(fd.get(), frame.data(), frame.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(frame.size());
}

/// The same message so many times, in one piece: how fast they come does not depend on how busy the computer is.
inline bool SendRawAtOnce(const sim::OwnedFd& fd, const std::string& json, int count) {
  const std::string frame = *BoothFrame(json);
  std::string all;
  for (int k = 0; k < count; ++k) all += frame;
  return ::send(fd.get(), all.data(), all.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(all.size());
}

/// Messages of a raw connection up to the first that is as wanted, which comes last; the connection's end ends them,
/// too.
inline std::vector<BoothMessage> ReadRaw(const sim::OwnedFd& fd, const std::function<bool(const BoothMessage&)>& last) {
  std::vector<BoothMessage> messages;
  const timeval limit{10, 0};
  ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
  // One frame at a time, no byte more: what follows is for whoever reads next.
  const auto take = [&](char* bytes, std::size_t count) {
    return ::recv(fd.get(), bytes, count, MSG_WAITALL) == static_cast<ssize_t>(count);
  };
  while (true) {
    unsigned char head[4];
    if (!take(reinterpret_cast<char*>(head), sizeof head)) return messages;
    const std::size_t length = head[0] | head[1] << 8U | head[2] << 16U | static_cast<std::size_t>(head[3]) << 24U;
    EXPECT_LE(length, kMaxBoothMessage);
    std::string text(std::min<std::size_t>(length, kMaxBoothMessage), ' ');
    if (!take(text.data(), text.size())) return messages;
    auto message = DecodeMessage(text);
    EXPECT_TRUE(message) << text;
    if (!message) return messages;
    messages.push_back(std::move(*message));
    if (last(messages.back())) return messages;
  }
}

}  // namespace annulus::test
