#include "tests/console_whole/bad_clients.h"

#include <fmt/format.h>

#include <csignal>
#include <fstream>
#include <stdexcept>

namespace annulus::test {
namespace {

using std::chrono::milliseconds;
using SteadyClock = std::chrono::steady_clock;

constexpr milliseconds kNoPatience{0};

}  // namespace

StuckClients::StuckClients(const ConsoleBrowser& browser, std::size_t count) : port_(browser.target().port) {
  for (std::size_t i = 0; i < count; ++i) {
    RawTarget target = browser.target();
    target.source = fmt::format("127.0.5.{}", i + 1);
    target.receive_buffer_bytes = 4096;
    const ConsoleBrowser nobody(target);
    auto socket = (i % 2 == 0 ? browser.From(target) : nobody).OpenLive();
    if (socket == nullptr) throw std::runtime_error("a stuck client was refused");
    sockets_.push_back(std::move(socket));
  }
}

std::size_t StuckClients::StillServed() const {
  // Address and port of both sides in hexadecimal, the address as the machine keeps it: 127.0.5.1 is 0105007F.
  const std::string ours = fmt::format("0100007F:{:04X}", port_);
  std::ifstream table("/proc/net/tcp");
  std::size_t found = 0;
  for (std::string line; std::getline(table, line);) {
    const std::size_t local = line.find(ours);
    if (local == std::string::npos) continue;
    const std::string remote = line.substr(local + ours.size() + 1, 8);
    const std::string state = line.substr(local + ours.size() + 1 + 14, 2);
    if (remote.ends_with("05007F") && state == "01") ++found;
  }
  return found;
}

BadClients::BadClients(const RawTarget& target) : target_(target) {
  std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes to a connection that the server has ended
  for (const auto work :
       {&BadClients::SendUnauthenticated, &BadClients::SendNoHttp, &BadClients::SendNoTls, &BadClients::SendSlowly}) {
    threads_.emplace_back([this, work](const std::stop_token& stop) { (this->*work)(stop); });
  }
}

double BadClients::Seconds() const { return std::chrono::duration<double>(SteadyClock::now() - begin_).count(); }

double BadClients::PerSecond() const { return (sent_[kUnauthenticated] + sent_[kNoHttp] + sent_[kNoTls]) / Seconds(); }

std::string BadClients::Text() const {
  const double s = Seconds();
  return fmt::format("{:.0f} unauthenticated/s, {:.0f} no HTTP/s, {:.0f} no TLS/s, {:.0f} slow bytes/s",
                     sent_[kUnauthenticated] / s, sent_[kNoHttp] / s, sent_[kNoTls] / s, sent_[kSlow] / s);
}

bool BadClients::NextOf(Kind kind, double per_second, const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (sent_[kind] < per_second * Seconds()) {
      ++sent_[kind];
      return true;
    }
    std::this_thread::sleep_for(milliseconds(1));
  }
  return false;
}

RawTarget BadClients::From(const std::string& address) const {
  RawTarget target = target_;
  target.source = address;
  return target;
}

void BadClients::SendUnauthenticated(const std::stop_token& stop) {
  constexpr std::size_t kClients = 8;
  std::vector<RawTarget> targets;
  std::vector<std::unique_ptr<RawClient>> clients(kClients);
  for (std::size_t i = 0; i < kClients; ++i) targets.push_back(From(fmt::format("127.0.1.{}", i + 1)));
  const ConsoleBrowser nobody(target_);
  RawTarget evil = target_;
  evil.name = "evil.example";
  const std::vector<std::string> requests{nobody.GetText("/api/customers"),
                                          nobody.PostText("/api/customers", {{"name", "Forged"}}),
                                          ConsoleBrowser(evil).PostText("/api/booth/home", {}), nobody.GetText("/")};
  const std::string login = nobody.PostText("/api/login", {{"user", "anna"}, {"password", "let me in now"}});
  constexpr std::size_t kLoginEvery = 200;
  for (std::size_t n = 0; NextOf(kUnauthenticated, 600.0, stop); ++n) {
    auto& client = clients[n % kClients];
    if (client == nullptr) client = RawClient::Connect(targets[n % kClients]);
    if (client == nullptr) continue;
    const std::string& request = n % kLoginEvery == 0 ? login : requests[n / kClients % requests.size()];
    if (client->Ask(request).status == 0) client.reset();
  }
}

void BadClients::SendNoHttp(const std::stop_token& stop) {
  for (std::size_t n = 0; NextOf(kNoHttp, 200.0, stop); ++n) {
    const auto client = RawClient::Connect(From(fmt::format("127.0.2.{}", n % 4 + 1)));
    if (client == nullptr || !client->Send("GET /../ HTTP/1.1\r\n\r\n")) continue;
    client->SetPatience(kNoPatience);
    client->Receive();
  }
}

void BadClients::SendNoTls(const std::stop_token& stop) {
  RawTarget target = From("127.0.3.1");
  target.authority_pem.clear();
  while (NextOf(kNoTls, 400.0, stop)) {
    const auto client = RawClient::Connect(target);
    if (client == nullptr || !client->Send("\x16\x03\x01nonsense\r\n\r\n")) continue;
    client->SetPatience(kNoPatience);
    client->Receive();
  }
}

void BadClients::SendSlowly(const std::stop_token& stop) {
  constexpr std::size_t kClients = 32;
  std::vector<std::unique_ptr<RawClient>> clients(kClients);
  for (std::size_t n = 0; NextOf(kSlow, 4.0 * kClients, stop); ++n) {
    auto& client = clients[n % kClients];
    if (client == nullptr) client = RawClient::Connect(From("127.0.4.1"));
    if (client == nullptr) continue;
    client->SetPatience(kNoPatience);
    if (!client->Send("G")) client.reset();
  }
}

}  // namespace annulus::test
