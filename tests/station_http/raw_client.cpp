#include "tests/station_http/raw_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace annulus::test {
namespace {

using Clock = std::chrono::steady_clock;

struct Address {
  sockaddr_storage storage{};
  socklen_t length = 0;
};

Address MakeAddress(const std::string& text, std::uint16_t port) {
  Address address;
  auto* v6 = reinterpret_cast<sockaddr_in6*>(&address.storage);
  auto* v4 = reinterpret_cast<sockaddr_in*>(&address.storage);
  if (::inet_pton(AF_INET6, text.c_str(), &v6->sin6_addr) == 1) {
    v6->sin6_family = AF_INET6;
    v6->sin6_port = htons(port);
    address.length = sizeof *v6;
  } else {
    ::inet_pton(AF_INET, text.c_str(), &v4->sin_addr);
    v4->sin_family = AF_INET;
    v4->sin_port = htons(port);
    address.length = sizeof *v4;
  }
  return address;
}

/// A connected TCP socket, −1 if there is none.
int ConnectTcp(const RawTarget& target) {
  const Address to = MakeAddress(target.address, target.port);
  const int fd = ::socket(to.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  if (target.receive_buffer_bytes > 0) {
    (void)::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &target.receive_buffer_bytes, sizeof target.receive_buffer_bytes);
  }
  const int on = 1;
  (void)::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  bool good = true;
  if (!target.source.empty()) {
    const Address from = MakeAddress(target.source, 0);
    good = ::bind(fd, reinterpret_cast<const sockaddr*>(&from.storage), from.length) == 0;
  }
  good = good && ::connect(fd, reinterpret_cast<const sockaddr*>(&to.storage), to.length) == 0;
  if (good) return fd;
  ::close(fd);
  return -1;
}

bool WaitFor(int fd, short events, Clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
  pollfd entry{fd, events, 0};
  return ::poll(&entry, 1, static_cast<int>(std::max<std::int64_t>(left, 0))) > 0;
}

class PlainClient : public RawClient {
 public:
  explicit PlainClient(int fd) : fd_(fd) {}
  ~PlainClient() override {
    if (fd_ >= 0) ::close(fd_);
  }

  bool Send(std::string_view bytes) override {
    const auto deadline = Clock::now() + patience_;
    while (!bytes.empty()) {
      const ssize_t sent = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent > 0) {
        bytes.remove_prefix(static_cast<std::size_t>(sent));
      } else if (errno != EAGAIN || !WaitFor(fd_, POLLOUT, deadline)) {
        return false;
      }
    }
    return true;
  }
  std::string Receive() override {
    if (!WaitFor(fd_, POLLIN, Clock::now() + patience_)) return {};
    std::array<char, 65'536> block{};
    const ssize_t got = ::recv(fd_, block.data(), block.size(), 0);
    return got > 0 ? std::string(block.data(), static_cast<std::size_t>(got)) : std::string();
  }
  void SetPatience(std::chrono::milliseconds patience) override { patience_ = patience; }
  void HalfClose() override { ::shutdown(fd_, SHUT_WR); }
  void Reset() override {
    const linger hard{1, 0};
    (void)::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &hard, sizeof hard);
    ::close(fd_);
    fd_ = -1;
  }

 protected:
  int fd_;
  std::chrono::milliseconds patience_{5000};
};

struct FreeTls {
  void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
  void operator()(SSL* ssl) const { SSL_free(ssl); }
};

class TlsClient final : public PlainClient {
 public:
  TlsClient(int fd, std::unique_ptr<SSL_CTX, FreeTls> context, std::unique_ptr<SSL, FreeTls> ssl)
      : PlainClient(fd), context_(std::move(context)), ssl_(std::move(ssl)) {}

  bool Send(std::string_view bytes) override {
    const auto deadline = Clock::now() + patience_;
    std::size_t sent = 0;
    while (!bytes.empty()) {
      ERR_clear_error();
      if (SSL_write_ex(ssl_.get(), bytes.data(), std::min<std::size_t>(bytes.size(), 16'384), &sent) == 1) {
        bytes.remove_prefix(sent);
      } else if (!Wait(0, deadline)) {
        return false;
      }
    }
    return true;
  }
  std::string Receive() override {
    const auto deadline = Clock::now() + patience_;
    std::array<char, 65'536> block{};
    std::size_t got = 0;
    while (true) {
      ERR_clear_error();
      if (SSL_read_ex(ssl_.get(), block.data(), block.size(), &got) == 1) return std::string(block.data(), got);
      if (!Wait(0, deadline)) return {};
    }
  }

 private:
  /// For what the last call wants; false if it is no wait that it wants, or the time is over.
  bool Wait(int result, Clock::time_point deadline) {
    switch (SSL_get_error(ssl_.get(), result)) {
      case SSL_ERROR_WANT_READ:
        return WaitFor(fd_, POLLIN, deadline);
      case SSL_ERROR_WANT_WRITE:
        return WaitFor(fd_, POLLOUT, deadline);
      default:
        return false;
    }
  }

  std::unique_ptr<SSL_CTX, FreeTls> context_;
  std::unique_ptr<SSL, FreeTls> ssl_;
};

std::unique_ptr<RawClient> ConnectTls(const RawTarget& target, int fd) {
  std::unique_ptr<SSL_CTX, FreeTls> context(SSL_CTX_new(TLS_client_method()));
  BIO* reader = BIO_new_mem_buf(target.authority_pem.data(), static_cast<int>(target.authority_pem.size()));
  X509* authority = PEM_read_bio_X509(reader, nullptr, nullptr, nullptr);
  X509_STORE_add_cert(SSL_CTX_get_cert_store(context.get()), authority);
  X509_free(authority);
  BIO_free(reader);
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, nullptr);
  SSL_CTX_set_mode(context.get(), SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  std::unique_ptr<SSL, FreeTls> ssl(SSL_new(context.get()));
  SSL_set_fd(ssl.get(), fd);
  SSL_set_tlsext_host_name(ssl.get(), target.name.c_str());
  SSL_set1_host(ssl.get(), target.name.c_str());
  // The handshake waits for at most five seconds in each direction.
  const timeval patience{5, 0};
  (void)::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  if (SSL_connect(ssl.get()) != 1) {
    ERR_clear_error();
    ::close(fd);
    return nullptr;
  }
  BIO_socket_nbio(fd, 1);
  return std::make_unique<TlsClient>(fd, std::move(context), std::move(ssl));
}

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return text;
}

}  // namespace

std::unique_ptr<RawClient> RawClient::Connect(const RawTarget& target) {
  const int fd = ConnectTcp(target);
  if (fd < 0) return nullptr;
  if (!target.authority_pem.empty()) return ConnectTls(target, fd);
  return std::make_unique<PlainClient>(fd);
}

bool RawClient::Fill() {
  const std::string more = Receive();
  pending_ += more;
  return !more.empty();
}

std::string RawClient::ReceiveAll() {
  while (Fill()) {
  }
  return std::exchange(pending_, {});
}

bool RawClient::SeesEnd() { return !Fill(); }

RawAnswer RawClient::ReadAnswer(bool head_only) {
  RawAnswer answer;
  std::size_t end = 0;
  while ((end = pending_.find("\r\n\r\n")) == std::string::npos) {
    if (!Fill()) return answer;
  }
  std::string head = pending_.substr(0, end + 2);
  pending_.erase(0, end + 4);
  if (!head.starts_with("HTTP/1.1 ")) return answer;
  const int status = std::stoi(head.substr(9, 3));
  for (std::size_t at = head.find("\r\n") + 2; at < head.size();) {
    const std::size_t line_end = head.find("\r\n", at);
    const std::string line = head.substr(at, line_end - at);
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) answer.headers[Lower(line.substr(0, colon))] = line.substr(colon + 2);
    at = line_end + 2;
  }
  const auto length = answer.headers.find("content-length");
  const std::size_t bytes = length == answer.headers.end() || head_only ? 0 : std::stoul(length->second);
  while (pending_.size() < bytes) {
    if (!Fill()) return answer;
  }
  answer.body = pending_.substr(0, bytes);
  pending_.erase(0, bytes);
  answer.status = status;
  return answer;
}

RawAnswer RawClient::Ask(std::string_view request) {
  (void)Send(request);
  return ReadAnswer();
}

RawAnswer RawClient::OpenWebSocket(const std::string& path, const std::string& more_headers) {
  // The key of RFC 6455 §1.3.
  return Ask("GET " + path +
             " HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n" +
             more_headers + "\r\n");
}

bool RawClient::SendFrame(int opcode, std::string_view payload, bool final) {
  constexpr std::array<char, 4> kMask{0x11, 0x22, 0x33, 0x44};
  std::string frame;
  frame.push_back(static_cast<char>((final ? 0x80 : 0) | opcode));
  if (payload.size() < 126) {
    frame.push_back(static_cast<char>(0x80U | payload.size()));
  } else if (payload.size() < 65'536) {
    frame.push_back(static_cast<char>(0x80 | 126));
    frame.push_back(static_cast<char>(payload.size() >> 8));
    frame.push_back(static_cast<char>(payload.size() & 0xFF));
  } else {
    frame.push_back(static_cast<char>(0x80 | 127));
    for (int shift = 56; shift >= 0; shift -= 8) frame.push_back(static_cast<char>(payload.size() >> shift & 0xFF));
  }
  frame.append(kMask.data(), kMask.size());
  for (std::size_t i = 0; i < payload.size(); ++i) frame.push_back(static_cast<char>(payload[i] ^ kMask[i % 4]));
  return Send(frame);
}

RawFrame RawClient::ReadFrame() {
  RawFrame frame;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(pending_[i]); };
  const auto need = [&](std::size_t bytes) {
    while (pending_.size() < bytes) {
      if (!Fill()) return false;
    }
    return true;
  };
  if (!need(2)) return frame;
  std::size_t length = byte(1) & 0x7FU;
  std::size_t head = 2;
  if (length == 126) head = 4;
  if (length == 127) head = 10;
  if (!need(head)) return frame;
  if (head > 2) {
    length = 0;
    for (std::size_t i = 2; i < head; ++i) length = length << 8 | byte(i);
  }
  if (!need(head + length)) return frame;
  frame.opcode = byte(0) & 0x0F;
  frame.final = (byte(0) & 0x80U) != 0;
  frame.payload = pending_.substr(head, length);
  pending_.erase(0, head + length);
  return frame;
}

std::string Get(const std::string& path, const std::string& more_headers) {
  return "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + more_headers + "\r\n";
}

std::string Post(const std::string& path, const std::string& body, const std::string& more_headers) {
  return "POST " + path + " HTTP/1.1\r\nHost: localhost\r\nContent-Length: " + std::to_string(body.size()) + "\r\n" +
         more_headers + "\r\n" + body;
}

}  // namespace annulus::test
