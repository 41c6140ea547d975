#include "acquisition/mcap_records.h"

#include <zlib.h>

namespace annulus {

std::uint32_t McapCrc(std::uint32_t crc, std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(crc32_z(crc, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

}  // namespace annulus
