#pragma once

#include "base/result.h"

namespace annulus {

/// Gives up, for this process with all its threads and for all that it starts from now on, what a console that listens
/// and reads its files does not need: no new privileges (setuid programs do nothing), no core dumps and no debugger
/// (what is in memory is not sealed), and by a seccomp filter: no mounting, tracing, kernel modules, clocks, reboot,
/// other namespaces, BPF, raw or network sockets (those that listen are open already; nothing of ours calls anybody but
/// boothd's Unix socket), and no ioctl of USB, GPIO, SPI, I2C, input or block devices. Called once everything listens.
/// Such calls fail with EPERM. An Error if the kernel has no seccomp.
Status GiveUpPrivileges();

/// The process runs as root.
[[nodiscard]] bool IsRoot();

}  // namespace annulus
