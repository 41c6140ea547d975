#include "station/console/security_headers.h"

#include <algorithm>
#include <array>
#include <utility>

namespace annulus {
namespace {

constexpr std::array<std::pair<const char*, const char*>, 6> kAlways{
    {{"Content-Security-Policy",
      "default-src 'self'; img-src 'self' blob: data:; style-src 'self'; script-src 'self'; connect-src 'self'; "
      "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
     {"X-Content-Type-Options", "nosniff"},
     {"Referrer-Policy", "no-referrer"},
     {"Cross-Origin-Opener-Policy", "same-origin"},
     {"Cross-Origin-Resource-Policy", "same-origin"},
     {"Permissions-Policy",
      "accelerometer=(), autoplay=(), camera=(), display-capture=(), encrypted-media=(), fullscreen=(), "
      "geolocation=(), "
      "gyroscope=(), hid=(), magnetometer=(), microphone=(), midi=(), payment=(), picture-in-picture=(), "
      "publickey-credentials-get=(), screen-wake-lock=(), serial=(), usb=(), xr-spatial-tracking=()"}}};

}  // namespace

void AddSecurityHeaders(HttpResponse& response, AnswerKind kind, bool loopback) {
  for (const auto& [name, value] : kAlways) response.headers.emplace_back(name, value);
  const bool says_itself = std::any_of(response.headers.begin(), response.headers.end(),
                                       [](const HttpField& field) { return field.first == "Cache-Control"; });
  if (kind == AnswerKind::kApi && !says_itself) response.headers.emplace_back("Cache-Control", "no-store");
  if (!loopback) response.headers.emplace_back("Strict-Transport-Security", "max-age=31536000");
}

}  // namespace annulus
