/// What a console can no longer do once it has given up its privileges (docs/security.md, "Process"). Each refusal is
/// shown by a call that the kernel would answer otherwise: every call is made with arguments that are wrong, in a child
/// with the filter and in one without.
#include "station/console/privileges.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <functional>
#include <future>
#include <string>
#include <thread>
#include <vector>

namespace annulus {
namespace {

/// Runs the body in a child of its own, which no terminal controls; its expectations count here.
void InChild(const std::function<void()>& body) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::setsid();
    body();
    std::fflush(nullptr);
    ::_exit(testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "see above; status " << status;
}

struct Call {
  const char* name;
  long number;
  std::vector<long> arguments;
};

/// The error of a call; 0 if it succeeded.
int ErrorOf(const Call& call) {
  long a[6] = {};
  std::copy(call.arguments.begin(), call.arguments.end(), a);
  return ::syscall(call.number, a[0], a[1], a[2], a[3], a[4], a[5]) >= 0 ? 0 : errno;
}

/// Of every kind that docs/security.md names, with a descriptor, pointer or number that is none.
std::vector<Call> PromisedCalls() {
  constexpr long kBad = -1;
  return {
      // Mounts.
      {"mount", SYS_mount, {kBad, kBad, kBad, 0, kBad}},
      {"umount2", SYS_umount2, {kBad, 0}},
      {"pivot_root", SYS_pivot_root, {kBad, kBad}},
      {"chroot", SYS_chroot, {kBad}},
      {"fsopen", SYS_fsopen, {kBad, 0}},
      {"fsmount", SYS_fsmount, {kBad, 0, 0}},
      {"move_mount", SYS_move_mount, {kBad, kBad, kBad, kBad, 0}},
      {"open_tree", SYS_open_tree, {kBad, kBad, 0}},
      {"setns", SYS_setns, {kBad, 0}},
      {"unshare", SYS_unshare, {1}},
      {"clone CLONE_NEWUSER", SYS_clone, {CLONE_NEWUSER | CLONE_THREAD}},
      {"clone CLONE_NEWNS", SYS_clone, {CLONE_NEWNS | CLONE_THREAD}},
      {"clone CLONE_NEWNET", SYS_clone, {CLONE_NEWNET | CLONE_THREAD}},
      {"clone CLONE_NEWPID", SYS_clone, {CLONE_NEWPID | CLONE_THREAD}},
      // Modules and kernels.
      {"init_module", SYS_init_module, {kBad, 8, kBad}},
      {"finit_module", SYS_finit_module, {kBad, kBad, 0}},
      {"delete_module", SYS_delete_module, {kBad, 0}},
      {"kexec_load", SYS_kexec_load, {0, 1000, kBad, kBad}},
      {"kexec_file_load", SYS_kexec_file_load, {kBad, kBad, 0, 0, kBad}},
      {"bpf", SYS_bpf, {kBad, kBad, 8}},
      // Tracing, other processes' memory and descriptors.
      {"ptrace", SYS_ptrace, {16, kBad, 0, 0}},
      {"process_vm_readv", SYS_process_vm_readv, {kBad, kBad, 1, kBad, 1, 0}},
      {"process_vm_writev", SYS_process_vm_writev, {kBad, kBad, 1, kBad, 1, 0}},
      {"pidfd_getfd", SYS_pidfd_getfd, {kBad, kBad, 0}},
      {"kcmp", SYS_kcmp, {kBad, kBad, 99}},
      {"perf_event_open", SYS_perf_event_open, {kBad, 0, 0, kBad, 0}},
      {"userfaultfd", SYS_userfaultfd, {0x40000000}},
      // Ways around the filter.
      {"io_uring_setup", SYS_io_uring_setup, {0, kBad}},
      {"io_uring_enter", SYS_io_uring_enter, {kBad, 0, 0, 0, 0, 0}},
      {"open_by_handle_at", SYS_open_by_handle_at, {kBad, kBad, 0}},
      // What is the machine's.
      {"reboot", SYS_reboot, {0, 0, 0, 0}},
      {"swapon", SYS_swapon, {kBad, 0}},
      {"clock_settime", SYS_clock_settime, {0, kBad}},
      {"clock_adjtime", SYS_clock_adjtime, {0, kBad}},
      {"settimeofday", SYS_settimeofday, {kBad, 0}},
      {"sethostname", SYS_sethostname, {kBad, 1}},
      {"syslog", SYS_syslog, {99, 0, 0}},
      {"acct", SYS_acct, {kBad}},
      {"keyctl", SYS_keyctl, {9999}},
      {"mknodat", SYS_mknodat, {kBad, kBad, 0, 0}},
#ifdef SYS_iopl
      {"iopl", SYS_iopl, {99}},
#endif
      // Devices, by the numbers of Linux's headers: USB reset, GPIO chip, SPI, I2C, input, HID, video, disk, SCSI, KVM.
      {"ioctl USBDEVFS_RESET", SYS_ioctl, {kBad, 0x5514}},
      {"ioctl GPIO_GET_CHIPINFO", SYS_ioctl, {kBad, 0x8044B401}},
      {"ioctl SPI_IOC_RD_MODE", SYS_ioctl, {kBad, 0x80016B01}},
      {"ioctl I2C_SLAVE", SYS_ioctl, {kBad, 0x0703}},
      {"ioctl EVIOCGVERSION", SYS_ioctl, {kBad, 0x80044501}},
      {"ioctl HIDIOCGRDESCSIZE", SYS_ioctl, {kBad, 0x80044801}},
      {"ioctl VIDIOC_QUERYCAP", SYS_ioctl, {kBad, 0x80685600}},
      {"ioctl BLKRRPART", SYS_ioctl, {kBad, 0x125F}},
      {"ioctl SG_IO", SYS_ioctl, {kBad, 0x2285}},
      {"ioctl KVM_GET_API_VERSION", SYS_ioctl, {kBad, 0xAE00}},
      {"ioctl TIOCSTI", SYS_ioctl, {kBad, 0x5412}},
      // The kernel looks at the lower half of the number only.
      {"ioctl TIOCSTI with an upper half", SYS_ioctl, {kBad, 0x100005412}},
      {"ioctl USBDEVFS_RESET with an upper half", SYS_ioctl, {kBad, 0x7FFF00005514}},
      // Network sockets; a type that is none.
      {"socket AF_INET", SYS_socket, {AF_INET, 99, 0}},
      {"socket AF_INET6", SYS_socket, {AF_INET6, 99, 0}},
      {"socket AF_NETLINK", SYS_socket, {AF_NETLINK, 99, 0}},
      {"socket AF_PACKET", SYS_socket, {AF_PACKET, 99, 0}},
      {"socket AF_CAN", SYS_socket, {AF_CAN, 99, 0}},
      {"socket AF_VSOCK", SYS_socket, {AF_VSOCK, 99, 0}},
  };
}

TEST(Privileges, EveryCallThatIsPromisedIsRefused) {
  InChild([] {
    // Whoever is root sees all of them; another user is refused some of them by the kernel as well.
    std::vector<int> without;
    for (const Call& call : PromisedCalls()) without.push_back(ErrorOf(call));
    ASSERT_TRUE(GiveUpPrivileges());
    std::size_t shown = 0;
    const std::vector<Call> calls = PromisedCalls();
    for (std::size_t i = 0; i < calls.size(); ++i) {
      EXPECT_EQ(ErrorOf(calls[i]), EPERM) << calls[i].name;
      if (without[i] != EPERM) ++shown;
    }
    std::printf("%zu of %zu calls are refused by nothing but the filter\n", shown, calls.size());
    EXPECT_GE(shown, IsRoot() ? calls.size() : calls.size() / 2);
  });
}

/// Its flags cannot be filtered, so that a namespace could be had by it.
TEST(Privileges, TheSecondCloneIsNotThere) {
  InChild([] {
    ASSERT_TRUE(GiveUpPrivileges());
    EXPECT_EQ(ErrorOf({"clone3", SYS_clone3, {-1, 88}}), ENOSYS);
  });
}

TEST(Privileges, WhatTheConsoleNeedsStaysPossible) {
  InChild([] {
    ASSERT_TRUE(GiveUpPrivileges());
    EXPECT_GE(::socket(AF_UNIX, SOCK_STREAM, 0), 0) << "boothd";
    int pair[2] = {};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, pair), 0);
    std::promise<void> ran;
    std::thread([&] { ran.set_value(); }).join();
    const pid_t job = ::fork();
    if (job == 0) {
      ::execl("/bin/true", "true", nullptr);
      ::_exit(127);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(job, &status, 0), job);
    EXPECT_EQ(status, 0) << "a job";
  });
}

TEST(Privileges, ThreadsThatRunAlreadyAreBoundToo) {
  InChild([] {
    std::promise<void> given_up;
    int error = 0;
    std::thread before([&] {
      given_up.get_future().wait();
      error = ErrorOf({"socket", SYS_socket, {AF_INET, SOCK_STREAM, 0}});
    });
    ASSERT_TRUE(GiveUpPrivileges());
    given_up.set_value();
    before.join();
    EXPECT_EQ(error, EPERM);
  });
}

TEST(Privileges, NoCoreNoDebuggerNoPrivilegesToGain) {
  InChild([] {
    ASSERT_TRUE(GiveUpPrivileges());
    rlimit core{};
    ASSERT_EQ(::getrlimit(RLIMIT_CORE, &core), 0);
    EXPECT_EQ(core.rlim_cur, 0U);
    EXPECT_EQ(core.rlim_max, 0U);
    EXPECT_EQ(::prctl(PR_GET_DUMPABLE, 0, 0, 0, 0), 0);
    EXPECT_EQ(::prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0), 1);
  });
}

/// What a job inherits, as the kernel says it of a program that was started.
TEST(Privileges, JobsInheritAllButTheDebuggersRefusal) {
  InChild([] {
    ASSERT_TRUE(GiveUpPrivileges());
    const pid_t job = ::fork();
    if (job == 0) {
      ::execl("/bin/sh", "sh", "-c",
              "grep -q '^Seccomp:[[:space:]]*2$' /proc/self/status && "
              "grep -q '^NoNewPrivs:[[:space:]]*1$' /proc/self/status && [ \"$(ulimit -c)\" = 0 ]",
              nullptr);
      ::_exit(127);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(job, &status, 0), job);
    EXPECT_EQ(status, 0);
  });
}

}  // namespace
}  // namespace annulus
