#include "station/console/privileges.h"

#include <sched.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

namespace annulus {
namespace {

using Filter = std::unique_ptr<void, decltype(&seccomp_release)>;

/// Nothing of ours makes these calls.
constexpr const char* kForbidden[] = {"mount",
                                      "umount2",
                                      "pivot_root",
                                      "chroot",
                                      "fsopen",
                                      "fsmount",
                                      "move_mount",
                                      "open_tree",
                                      "fspick",
                                      "fsconfig",
                                      "mount_setattr",
                                      "ptrace",
                                      "process_vm_readv",
                                      "process_vm_writev",
                                      "pidfd_getfd",
                                      "kcmp",
                                      "init_module",
                                      "finit_module",
                                      "delete_module",
                                      "kexec_load",
                                      "kexec_file_load",
                                      "bpf",
                                      "perf_event_open",
                                      "userfaultfd",
                                      "add_key",
                                      "request_key",
                                      "keyctl",
                                      "reboot",
                                      "swapon",
                                      "swapoff",
                                      "settimeofday",
                                      "clock_settime",
                                      "clock_adjtime",
                                      "adjtimex",
                                      "sethostname",
                                      "setdomainname",
                                      "iopl",
                                      "ioperm",
                                      "setns",
                                      "unshare",
                                      "quotactl",
                                      "acct",
                                      "syslog",
                                      "name_to_handle_at",
                                      "open_by_handle_at",
                                      "io_uring_setup",
                                      "io_uring_enter",
                                      "io_uring_register",
                                      "mknod",
                                      "mknodat",
                                      "vhangup",
                                      "lookup_dcookie",
                                      "fanotify_init"};

/// Second byte of an ioctl's number: of which kind of device it is (Documentation/userspace-api/ioctl).
constexpr std::array<unsigned, 10> kDeviceIoctls{
    'U' << 8,   // usbfs
    0xB4 << 8,  // GPIO
    'k' << 8,   // SPI
    0x07 << 8,  // I2C
    'E' << 8,   // input
    'H' << 8,   // HID raw
    'V' << 8,   // video
    0x12 << 8,  // block
    0x22 << 8,  // SCSI generic
    0xAE << 8,  // KVM
};
constexpr unsigned kPushCharacter = 0x5412;  // TIOCSTI types into somebody's terminal
constexpr unsigned kConsoleMenu = 0x541C;    // TIOCLINUX

/// Flags of clone that ask for a namespace.
constexpr std::array<unsigned long, 7> kNamespaces{CLONE_NEWNS,   CLONE_NEWCGROUP, CLONE_NEWUTS, CLONE_NEWIPC,
                                                   CLONE_NEWUSER, CLONE_NEWPID,    CLONE_NEWNET};

constexpr std::uint32_t kDeny = SCMP_ACT_ERRNO(EPERM);

Status Forbid(void* filter) {
  for (const char* name : kForbidden) {
    const int number = seccomp_syscall_resolve_name(name);
    if (number == __NR_SCMP_ERROR) continue;  // libseccomp knows no such call: neither does this kernel's age of ours
    if (seccomp_rule_add(filter, kDeny, number, 0) < 0) return Fail("make a filter of system calls", name, "report it");
  }
  int failed = 0;
  for (const unsigned kind : kDeviceIoctls) {
    failed |= seccomp_rule_add(filter, kDeny, SCMP_SYS(ioctl), 1, SCMP_A1(SCMP_CMP_MASKED_EQ, 0xFF00U, kind));
  }
  for (const unsigned one : {kPushCharacter, kConsoleMenu}) {
    failed |= seccomp_rule_add(filter, kDeny, SCMP_SYS(ioctl), 1, SCMP_A1(SCMP_CMP_MASKED_EQ, 0xFFFFFFFFU, one));
  }
  for (const unsigned long flag : kNamespaces) {
    failed |= seccomp_rule_add(filter, kDeny, SCMP_SYS(clone), 1, SCMP_A0(SCMP_CMP_MASKED_EQ, flag, flag));
  }
  // Its flags are behind a pointer, where no filter sees them; the C library takes clone then.
  failed |= seccomp_rule_add(filter, SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
  failed |= seccomp_rule_add(filter, kDeny, SCMP_SYS(socket), 1, SCMP_A0(SCMP_CMP_NE, AF_UNIX));
  if (failed < 0) return Fail("make a filter of system calls", "a rule was refused", "report it");
  return {};
}

}  // namespace

Status GiveUpPrivileges() {
  const rlimit no_core{0, 0};
  if (::setrlimit(RLIMIT_CORE, &no_core) != 0 || ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0 ||
      ::prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) != 0) {
    return Fail("give up privileges", std::strerror(errno), "run on Linux 3.5 or later");
  }
  const Filter filter(seccomp_init(SCMP_ACT_ALLOW), &seccomp_release);
  if (filter == nullptr) return Fail("make a filter of system calls", "libseccomp failed", "end other programs");
  RETURN_IF_ERROR(Forbid(filter.get()));
  // All threads: those of the server are running already.
  if (const int failed = seccomp_attr_set(filter.get(), SCMP_FLTATR_CTL_TSYNC, 1); failed < 0) {
    return Fail("filter system calls", std::strerror(-failed), "run on a kernel with seccomp (Linux 3.17 or later)");
  }
  if (const int failed = seccomp_load(filter.get()); failed < 0) {
    return Fail("filter system calls", std::strerror(-failed), "run on a kernel with seccomp filters");
  }
  return {};
}

bool IsRoot() { return ::geteuid() == 0; }

}  // namespace annulus
