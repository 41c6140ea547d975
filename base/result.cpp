#include "base/result.h"

namespace annulus {

std::string Error::Text() const {
  std::string text = attempted + ": " + seen + ": " + advice;
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return text;
}

}  // namespace annulus
