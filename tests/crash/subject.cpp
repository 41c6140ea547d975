#include "subject.h"

#include <algorithm>

namespace annulus::test {
namespace {

class OneKey final : public KeySource {
 public:
  [[nodiscard]] Result<SealKey> Key(const std::string& id) const override {
    if (id != kId) return Fail("find the key " + id, "it is not known", "take the key file of its station");
    SealKey key;
    std::fill(key.bytes.begin(), key.bytes.end(), static_cast<unsigned char>(0x5A));
    return key;
  }
  [[nodiscard]] Result<std::string> NewRecordingKeyId() const override { return std::string(kId); }

 private:
  static constexpr const char* kId = "crash-test";
};

}  // namespace

const KeySource& TestKeys() {
  static const OneKey keys;
  return keys;
}

Result<Recording> HonestReader(std::span<const std::byte> bytes) {
  return ParseRecording(bytes, "the remains", &TestKeys());
}

Result<bool> HonestRecoverer(Storage& storage, const std::string& from, const std::string& to) {
  const auto read = ReadWholeRecording(storage, from);
  if (!read) return Fail(read);
  RETURN_IF_ERROR(WriteRecording(storage, to, read->scan));
  return read->report.clean();
}

}  // namespace annulus::test
