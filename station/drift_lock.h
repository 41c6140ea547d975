#pragma once

#include <string>

#include "base/result.h"
#include "sim/unix_socket.h"

namespace annulus {

/// Held while a drift history is read, added to and written: what another program adds in between would be lost. It is
/// the lock of the history's folder, since the file itself is replaced; the kernel lets go of it however we end. Fails
/// at once, with nothing changed, if another program holds it, or if there is no such folder.
[[nodiscard]] Result<sim::OwnedFd> LockDriftHistory(const std::string& path);

}  // namespace annulus
