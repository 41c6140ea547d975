#pragma once

#include <string>
#include <string_view>

#include "base/result.h"

namespace annulus {

/// Argon2id (RFC 9106), version 1.3: 64 MiB, two passes, one lane; more than OWASP's least (19 MiB, two passes).
/// The hash carries its salt and parameters. One is computed at a time, so that guessing costs the machine one core and
/// 64 MiB at most. Thread-safe.
[[nodiscard]] Result<std::string> HashPassword(std::string_view password);

/// Whether `password` is that of `hash`. An empty or damaged hash is never matched, but takes the same time, so that
/// an account that is not there cannot be told from one that is. Thread-safe.
[[nodiscard]] bool VerifyPassword(const std::string& hash, std::string_view password);

/// Whether a password may be taken: at least 12 characters, at most 256 bytes, UTF-8 without control characters, not a
/// common one (common_passwords.h), not made of the user's name (ASVS 5.0 §6.2). Nothing else is asked of it.
[[nodiscard]] Status CheckNewPassword(std::string_view password, std::string_view user);

/// Whether a PIN may be taken (of operators, on the booth's own screen only): 6 … 12 digits, not one digit repeated,
/// not counted up or down, not a pattern repeated.
[[nodiscard]] Status CheckNewPin(std::string_view pin);

/// A password of 20 random letters and digits that cannot be taken for each other, in groups of five: 100 bits. At
/// 10^12 guesses a second that lasts for ages.
[[nodiscard]] std::string RandomPassword();

}  // namespace annulus
