#include "subject.h"

#include "acquisition/recording_recovery.h"
#include "tests/support/test_keys.h"

namespace annulus::test {
const KeySource& CrashKeys() {
  static const TestKeys keys;
  return keys;
}

Result<Recording> HonestReader(std::span<const std::byte> bytes) {
  return ParseRecording(bytes, "the remains", &CrashKeys());
}

Result<bool> HonestRecoverer(Storage& storage, const std::string& from, const std::string& to) {
  const auto recovered = RecoverRecording(storage, from, to, &CrashKeys());
  if (!recovered) return Fail(recovered);
  return recovered->lossless;
}

}  // namespace annulus::test
