#pragma once

#include <cstdint>
#include <vector>

#include "firmware_iface/axis_register_map.h"

namespace annulus {

/// The registers of one answered transaction, by address.
class RegisterBlock {
 public:
  RegisterBlock(std::uint16_t address, WordOrder order, std::vector<std::uint16_t> values);

  /// Whether the two registers of a 32-bit value are there.
  [[nodiscard]] bool HasLong(std::uint16_t address) const;

  // The registers asked for must be there.
  [[nodiscard]] std::uint16_t Word(std::uint16_t address) const;
  [[nodiscard]] std::uint32_t Long(std::uint16_t address) const;
  [[nodiscard]] std::int32_t Signed(std::uint16_t address) const;

 private:
  std::uint16_t address_;
  WordOrder order_;
  std::vector<std::uint16_t> values_;
};

}  // namespace annulus
