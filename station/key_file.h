#pragma once

#include <memory>
#include <string>

#include "acquisition/sealed_file.h"
#include "base/result.h"

namespace annulus {

/// The keys in a text file with one line `ID = KEY` each (ID: 1 … 32 letters, digits, '-', '_' or '.'; KEY: 64 hex
/// digits), blank lines and lines that begin with '#' left out. The last key is the one for new recordings. Refuses a
/// file that anybody but its owner may read or write.
Result<std::unique_ptr<KeySource>> ReadKeyFile(const std::string& path);

/// The same; null if `path` is empty.
Result<std::unique_ptr<KeySource>> OpenKeys(const std::string& path);

}  // namespace annulus
