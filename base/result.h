#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace annulus {

/// What went wrong in the world, in the three parts that every message of ours has.
/// Printed as `attempted: seen: advice`, on one line.
struct Error {
  std::string attempted;  ///< What was tried, on what ("read scan.csv").
  std::string seen;       ///< What was observed, with the place ("line 7: range_mm is 'abc'").
  std::string advice;     ///< What the reader can do about it.

  /// The three parts joined by ": "; control characters replaced, so that it stays one line.
  [[nodiscard]] std::string Text() const;
};

/// A value, or the Error that prevented it. Nothing else but ENSURE throws across a folder.
template <class T>
using Result = tl::expected<T, Error>;

/// Success, or an Error.
using Status = Result<void>;

/// Makes the failure side of any Result<T>.
[[nodiscard]] inline tl::unexpected<Error> Fail(std::string attempted, std::string seen, std::string advice) {
  return tl::unexpected<Error>(Error{std::move(attempted), std::move(seen), std::move(advice)});
}

/// Forwards the error of one Result as that of another type.
template <class T>
[[nodiscard]] tl::unexpected<Error> Fail(const Result<T>& failed) {
  return tl::unexpected<Error>(failed.error());
}

}  // namespace annulus

/// Leaves the function with the error of `expression` (a Status or Result) if it failed.
#define RETURN_IF_ERROR(expression)                                                                  \
  do {                                                                                               \
    if (auto annulus_status = (expression); !annulus_status) return ::annulus::Fail(annulus_status); \
  } while (false)
