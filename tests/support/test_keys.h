#pragma once

#include <map>
#include <string>

#include "acquisition/sealed_file.h"

namespace annulus::test {

/// Keys in memory; "k1" is for new recordings.
class TestKeys final : public KeySource {
 public:
  TestKeys() {
    for (unsigned char i = 0; i < SealKey::kBytes; ++i) keys["k1"].bytes[i] = static_cast<unsigned char>(3 * i + 1);
  }
  [[nodiscard]] Result<SealKey> Key(const std::string& id) const override {
    const auto found = keys.find(id);
    if (found == keys.end()) return Fail("find the key '" + id + "'", "it is not there", "add it");
    return found->second;
  }
  [[nodiscard]] Result<std::string> NewRecordingKeyId() const override { return std::string("k1"); }

  std::map<std::string, SealKey> keys;
};

}  // namespace annulus::test
