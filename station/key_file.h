#pragma once

#include <memory>
#include <string>

#include "acquisition/sealed_file.h"
#include "base/result.h"
#include "station/config.h"

namespace annulus {

/// The keys in a text file with one line `ID = KEY` each (ID: 1 … 32 letters, digits, '-', '_' or '.'; KEY: 64 hex
/// digits), blank lines and lines that begin with '#' left out. The last key is the one for new recordings. Refuses a
/// file that anybody but its owner may read or write.
Result<std::unique_ptr<KeySource>> ReadKeyFile(const std::string& path);

/// Recordings of people who were really scanned are sealed: an Error if a real device is in the configuration and there
/// is no key file.
[[nodiscard]] Status CheckSealing(const Config& config, const std::string& key_file);

/// The same as ReadKeyFile; null if `path` is empty.
Result<std::unique_ptr<KeySource>> OpenKeys(const std::string& path);

}  // namespace annulus
