#pragma once

#include <stdexcept>
#include <string>

namespace annulus {

/// Thrown by ENSURE when the program itself is wrong. Caught only in main(), which stops the axis and exits 1.
class LogicError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws LogicError with the place and the broken condition. Called by ENSURE only.
[[noreturn]] void FailEnsure(const char* file, int line, const char* condition, const std::string& message);

}  // namespace annulus

/// Always-on check of what the program promises itself (never of what the world does: that is a Result).
#define ENSURE(condition, message)                                      \
  do {                                                                  \
    if (!(condition)) {                                                 \
      ::annulus::FailEnsure(__FILE__, __LINE__, #condition, (message)); \
    }                                                                   \
  } while (false)
