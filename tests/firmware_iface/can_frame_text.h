#pragma once

#include <cstdio>
#include <string>

#include "firmware_iface/can_bus.h"

namespace annulus {

/// A frame as can-utils write it: "188#F2AB" classic, "188##F2AB…" FD with bit rate switch (without their flags digit).
inline std::string TextOf(const CanFrame& frame) {
  char part[16];
  std::snprintf(part, sizeof(part), frame.extended ? "%08X" : "%03X", static_cast<unsigned>(frame.id));
  std::string text = std::string(part) + (frame.fd ? "##" : "#");
  for (std::size_t i = 0; i < frame.size; ++i) {
    std::snprintf(part, sizeof(part), "%02X", std::to_integer<unsigned>(frame.data[i]));
    text += part;
  }
  return text;
}

inline CanFrame FrameOf(const std::string& text) {
  CanFrame frame;
  const std::size_t hash = text.find('#');
  frame.id = static_cast<std::uint32_t>(std::stoul(text.substr(0, hash), nullptr, 16));
  frame.fd = text[hash + 1] == '#';
  frame.bit_rate_switch = frame.fd;
  const std::string data = text.substr(hash + (frame.fd ? 2 : 1));
  frame.size = static_cast<std::uint8_t>(data.size() / 2);
  for (std::size_t i = 0; i < frame.size; ++i) {
    frame.data[i] = static_cast<std::byte>(std::stoi(data.substr(2 * i, 2), nullptr, 16));
  }
  return frame;
}

}  // namespace annulus
