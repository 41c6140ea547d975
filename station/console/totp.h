#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"

namespace annulus {

/// Time-based one-time passwords (RFC 6238 over RFC 4226: HMAC-SHA-1, 30 s, as every authenticator has them).
inline constexpr std::chrono::seconds kTotpStep{30};

/// The code of time step `step` (seconds since 1970 over 30): `digits` decimal digits, 6 … 8. `key` is any bytes.
[[nodiscard]] std::string TotpCode(std::string_view key, std::uint64_t step, int digits = 6);

/// The second factor of one user, as it is kept (sealed) in the store.
struct TotpSecret {
  std::string key;              ///< 20 random bytes.
  std::uint64_t last_step = 0;  ///< No code of this step or an earlier one is taken again.

  [[nodiscard]] static TotpSecret Random();
  /// "BASE32 LAST", and back; an Error if it is none.
  [[nodiscard]] std::string Text() const;
  [[nodiscard]] static Result<TotpSecret> Parse(std::string_view text);
  /// What authenticators take, as text or QR code: "otpauth://totp/annulus:USER?secret=…&issuer=annulus". `user` is of
  /// the letters that user names have.
  [[nodiscard]] std::string Uri(const std::string& user) const;
};

/// The step that `code` (6 digits) is of: now, the one before, or the one after, since clocks differ, but later than
/// secret.last_step. Nothing if it is of none. All three are compared, each in constant time.
[[nodiscard]] std::optional<std::uint64_t> VerifyTotp(const TotpSecret& secret, std::string_view code,
                                                      std::chrono::nanoseconds wall);

}  // namespace annulus
