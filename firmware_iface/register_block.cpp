#include "firmware_iface/register_block.h"

#include <cstddef>
#include <utility>

namespace annulus {

RegisterBlock::RegisterBlock(std::uint16_t address, WordOrder order, std::vector<std::uint16_t> values)
    : address_(address), order_(order), values_(std::move(values)) {}

bool RegisterBlock::HasLong(std::uint16_t address) const {
  return address >= address_ && static_cast<std::size_t>(address - address_) + 2 <= values_.size();
}

std::uint16_t RegisterBlock::Word(std::uint16_t address) const {
  return values_.at(static_cast<std::size_t>(address - address_));
}

std::uint32_t RegisterBlock::Long(std::uint16_t address) const {
  const std::uint32_t first = Word(address);
  const std::uint32_t second = Word(static_cast<std::uint16_t>(address + 1));
  return order_ == WordOrder::kHighFirst ? first << 16 | second : second << 16 | first;
}

std::int32_t RegisterBlock::Signed(std::uint16_t address) const { return static_cast<std::int32_t>(Long(address)); }

}  // namespace annulus
