#include "subject.h"

namespace annulus::test {

Result<Recording> HonestReader(std::span<const std::byte> bytes) { return ParseRecording(bytes, "the remains"); }

Result<bool> HonestRecoverer(Storage& storage, const std::string& from, const std::string& to) {
  const auto read = ReadWholeRecording(storage, from);
  if (!read) return Fail(read);
  RETURN_IF_ERROR(WriteRecording(storage, to, read->scan));
  return read->report.clean();
}

}  // namespace annulus::test
