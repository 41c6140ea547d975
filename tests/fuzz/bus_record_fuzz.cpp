/// The records of raw bus traffic. Beyond "no crash": what is accepted, written again, reads back as the same bytes,
/// and cutting any of those off is noticed.
///
/// Input: eight bytes of time, then the record.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <variant>

#include "acquisition/bus_record.h"
#include "base/ensure.h"

using namespace annulus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::int64_t time = 0;
  if (size < sizeof(time)) return 0;
  std::memcpy(&time, data, sizeof(time));
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(sizeof(time));
  const RawRecord given{RawChannel::kUsb, std::chrono::nanoseconds(time), {bytes.begin(), bytes.end()}};
  const auto decoded = DecodeBusRecord(given);
  if (!decoded) {
    ENSURE(!decoded.error().advice.empty(), "a refusal says what to do");
    return 0;
  }
  if (std::holds_alternative<bus_record::Unknown>(*decoded)) return 0;
  const RawRecord once = EncodeBusRecord(*decoded, given.time);
  const auto again = DecodeBusRecord(once);
  ENSURE(again.has_value() && again->index() == decoded->index(), "what was written can be read");
  ENSURE(EncodeBusRecord(*again, given.time).bytes == once.bytes, "a record reads back as it was");
  RawRecord cut = once;
  cut.bytes.pop_back();
  ENSURE(!DecodeBusRecord(cut), "a record that is cut is refused");
  return 0;
}
