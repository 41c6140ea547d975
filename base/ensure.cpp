#include "base/ensure.h"

#include <cstring>

namespace annulus {

void FailEnsure(const char* file, int line, const char* condition, const std::string& message) {
  const char* slash = std::strrchr(file, '/');
  const std::string place = std::string(slash != nullptr ? slash + 1 : file) + ":" + std::to_string(line);
  throw LogicError("internal error at " + place + ": " + condition + " does not hold: " + message);
}

}  // namespace annulus
