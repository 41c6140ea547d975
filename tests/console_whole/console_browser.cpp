#include "tests/console_whole/console_browser.h"

#include <stdexcept>
#include <utility>

#include "base/clock.h"

namespace annulus::test {
namespace {

using std::chrono::milliseconds;

constexpr std::chrono::seconds kPatience{20};

// RFC 6455 §11.8.
constexpr int kText = 1;
constexpr int kClose = 8;
constexpr int kPing = 9;
constexpr int kPong = 10;

}  // namespace

ConsoleBrowser::ConsoleBrowser(RawTarget target) : target_(std::move(target)) {}

std::string ConsoleBrowser::Head() const {
  const std::string host = target_.name + ":" + std::to_string(target_.port);
  std::string head = "Host: " + host + "\r\nOrigin: https://" + host + "\r\nSec-Fetch-Site: same-origin\r\n";
  if (!cookie_.empty()) head += "Cookie: __Host-annulus=" + cookie_ + "\r\n";
  return head;
}

std::string ConsoleBrowser::GetText(const std::string& path) const {
  return "GET " + path + " HTTP/1.1\r\n" + Head() + "\r\n";
}

std::string ConsoleBrowser::PostText(const std::string& path, const nlohmann::json& body) const {
  const std::string text = body.dump();
  return "POST " + path + " HTTP/1.1\r\n" + Head() + "Content-Type: application/json\r\nX-CSRF-Token: " + csrf_ +
         "\r\nContent-Length: " + std::to_string(text.size()) + "\r\n\r\n" + text;
}

ConsoleBrowser::Answer ConsoleBrowser::Send(const std::string& request) {
  const auto begin = SystemClock().Now();
  Answer answer;
  answer.json = nlohmann::json::object();
  auto client = RawClient::Connect(target_);
  // A handshake has five seconds, which on a busy machine may be too few.
  while (client == nullptr && SystemClock().Now() - begin < kPatience) client = RawClient::Connect(target_);
  if (client == nullptr) return answer;
  client->SetPatience(kPatience);
  const RawAnswer raw = client->Ask(request);
  answer.took = std::chrono::duration_cast<milliseconds>(SystemClock().Now() - begin);
  answer.status = raw.status;
  answer.json = nlohmann::json::parse(raw.body, nullptr, false);
  if (const auto cookie = raw.headers.find("set-cookie"); cookie != raw.headers.end()) {
    const std::size_t value = cookie->second.find('=') + 1;
    cookie_ = cookie->second.substr(value, cookie->second.find(';') - value);
  }
  if (answer.json.is_object() && answer.json.contains("csrf")) csrf_ = answer.json.at("csrf").get<std::string>();
  return answer;
}

ConsoleBrowser::Answer ConsoleBrowser::Get(const std::string& path) { return Send(GetText(path)); }

ConsoleBrowser::Answer ConsoleBrowser::Post(const std::string& path, const nlohmann::json& body) {
  return Send(PostText(path, body));
}

ConsoleBrowser::Answer ConsoleBrowser::LogIn(const std::string& user) {
  Get("/api/session");
  return Post("/api/login", {{"user", user}, {"password", kPassword}});
}

std::unique_ptr<RawClient> ConsoleBrowser::OpenLive() const {
  auto client = RawClient::Connect(target_);
  if (client == nullptr) return nullptr;
  client->SetPatience(kPatience);
  // The key of RFC 6455 §1.3.
  const RawAnswer answer = client->Ask("GET /api/live HTTP/1.1\r\n" + Head() +
                                       "Upgrade: websocket\r\nConnection: Upgrade\r\n"
                                       "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                                       "Sec-WebSocket-Version: 13\r\n\r\n");
  return answer.status == 101 ? std::move(client) : nullptr;
}

ConsoleBrowser ConsoleBrowser::From(RawTarget target) const {
  ConsoleBrowser same = *this;
  same.target_ = std::move(target);
  return same;
}

LiveListener::LiveListener(std::unique_ptr<RawClient> socket) : socket_(std::move(socket)) {
  if (socket_ == nullptr) throw std::runtime_error("the console refused a WebSocket");
  thread_ = std::jthread([this](const std::stop_token& stop) { Listen(stop); });
}

LiveListener::~LiveListener() {
  thread_.request_stop();
  thread_.join();
  socket_->Reset();
}

void LiveListener::Listen(const std::stop_token& stop) {
  constexpr milliseconds kLook{100};
  const SystemClock clock;
  socket_->SetPatience(kLook);
  while (!stop.stop_requested()) {
    const auto begin = clock.Now();
    const RawFrame frame = socket_->ReadFrame();
    const auto came = clock.Now();
    if (frame.opcode == kPing) socket_->SendFrame(kPong, frame.payload);
    const bool over = frame.opcode == kClose || (frame.opcode < 0 && came - begin < kLook / 2);
    const std::lock_guard lock(mutex_);
    if (frame.opcode == kText) heard_.push_back({nlohmann::json::parse(frame.payload), came});
    if (over) {
      const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(frame.payload[i]); };
      ended_ = frame.payload.size() < 2 ? 0 : byte(0) << 8 | byte(1);
    }
    changed_.notify_all();
    if (over) return;
  }
}

nlohmann::json LiveListener::WaitFor(const std::string& type) {
  std::unique_lock lock(mutex_);
  nlohmann::json found;
  changed_.wait_for(lock, kPatience, [&] {
    for (const Heard& one : heard_) {
      if (one.message.at("type") == type) found = one.message;
    }
    return !found.is_null();
  });
  return found;
}

int LiveListener::WaitForEnd() {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, kPatience, [&] { return ended_.has_value(); });
  return ended_.value_or(-1);
}

std::vector<LiveListener::Heard> LiveListener::All() const {
  const std::lock_guard lock(mutex_);
  return heard_;
}

}  // namespace annulus::test
