#pragma once

#include <memory>
#include <string>

#include "base/result.h"

namespace annulus {

/// Where opened files of customers lie while a job works on them: a folder of mode 0700 on a file system in memory
/// (/dev/shm, else $XDG_RUNTIME_DIR; on disk only if neither is there, which problem() says). It goes with its console;
/// what one that was killed has left, the next one removes. Thread-safe.
class ScratchFolder {
 public:
  /// In `preferred`; "": as said above.
  static Result<std::unique_ptr<ScratchFolder>> Make(const std::string& preferred);
  virtual ~ScratchFolder() = default;
  /// A new, empty folder in it.
  virtual Result<std::string> NewFolder() = 0;
  virtual void Remove(const std::string& folder) = 0;
  [[nodiscard]] virtual const std::string& path() const = 0;
  [[nodiscard]] virtual std::string problem() const = 0;
};

}  // namespace annulus
