#pragma once

#include <functional>
#include <string>

#include "recorded_trace.h"

namespace annulus::test {

/// The key of every sealed recording here.
const KeySource& TestKeys();

/// How bytes become a recording: ParseRecording with TestKeys, or a planted defect around it.
using Reader = std::function<Result<Recording>(std::span<const std::byte> bytes)>;
Result<Recording> HonestReader(std::span<const std::byte> bytes);

/// How a damaged recording becomes a sound one: true if nothing was lost.
using Recoverer = std::function<Result<bool>(Storage& storage, const std::string& from, const std::string& to)>;
Result<bool> HonestRecoverer(Storage& storage, const std::string& from, const std::string& to);

/// What the properties are asked of. The default is the production code on a disk that does what it says.
struct Subject {
  Defect below{};  ///< Between the disk and what the writer is told.
  Defect above{};  ///< Between the writer and what it asks for.
  Sealing sealing = Sealing::kPlain;
  Reader reader = HonestReader;
  Recoverer recover = HonestRecoverer;
};

}  // namespace annulus::test
