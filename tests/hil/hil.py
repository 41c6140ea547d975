#!/usr/bin/python3
"""Drivers on a real Linux kernel: boots Debian's kernel in QEMU and runs the contract suites in it.

Prints a table and `N passed, N failed`; exit 0 if none failed. Serial logs are left in build/hil/. The kernel is downloaded once
into build/hil/cache, or the folder that ANNULUS_HIL_CACHE names. docs/developer.md, "Drivers on a real kernel".
"""

import argparse
import dataclasses
import os
import re
import shutil
import signal
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # keeps the source tree clean
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from debian_kernel import HilError, KernelCache  # noqa: E402
from initramfs import Initramfs  # noqa: E402
from machine import VERDICT, Requests, boot  # noqa: E402
import peers  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
BEGIN = time.monotonic()


@dataclasses.dataclass(frozen=True)
class Suite:
    """One machine: what is plugged in, which drivers, which tests, how long at most (s)."""

    pattern: str  # of GoogleTest
    modules: tuple
    seconds: int
    devices: tuple = ()
    peer: type = peers.NoPeer
    built: bool = False  # needs drivers that Debian does not build
    udev: bool = False
    long_only: tuple = ()  # tests that the short run leaves out
    complaint: str = ""  # a warning of the kernel that is expected


CAN_BUS = ("-object", "can-bus,id=cb")
# What QEMU's controllers cannot do is left out and has a test of its own: tests/hil/guest/can_controllers_test.cpp says why.
SUITES = {
    "can": Suite("Can*:-CanKernel/CanBusContract.CarriesStandardAndExtended*/Kvaser",
                 ("can-raw", "vcan", "kvaser_pci", "sch_tbf"), 450,
                 CAN_BUS + ("-device", "kvaser_pci,canbus=cb", "-device", "kvaser_pci,canbus=cb"),
                 long_only=("*RangeRingContract.*/VcanFd", "*RangeRingContract.StreamsAgainAfterReplug*",
                            "*RangeRingContract.SaysByTheDeadline*", "*CanBusContract.CountsWhatItLost*")),
    "canfd": Suite("FdCan*:-FdCanKernel/CanBusContract.SaysHowTheInterfaceIsSetUp/CtuCan", ("can-raw", "ctucanfd_pci"), 240,
                   CAN_BUS + ("-device", "ctucan_pci,canbus0=cb,canbus1=cb"), built=True),
    "usb": Suite("Usb*:-", ("xhci_pci",), 600, peer=peers.UsbBoards, udev=True,
                 long_only=("*RangeRingContract.StreamsAgainAfterReplug*", "*RangeRingContract.SaysByTheDeadline*")),
    # gpio-sim warns when a chip is removed whose edges are watched, which is what a test does.
    "gpio": Suite("Gpio*", ("gpio-sim",), 300, built=True, udev=True, complaint="remove_proc_entry"),
    # The board's serial port has no plug.
    "modbus": Suite("Modbus*:-ModbusBoardPort/*.IsLostWhenUnplugged*:ModbusBoardPort/*.LosesItsHome*", ("xhci_pci", "ftdi_sio"), 450,
                    peer=peers.AxisDrives, udev=True),
}
GROUPS = {"all": tuple(SUITES), "short": ("can", "usb")}


def say(text):
    seconds = int(time.monotonic() - BEGIN)
    print(f"hil: [{seconds // 60:02d}:{seconds % 60:02d}] {text}", flush=True)


def count(lines):
    """(passed, failed names) of GoogleTest's output. A test that began and did not end counts as failed."""
    # The kernel may write into the middle of a line, so only what is on the line counts.
    began = [m.group(1) for line in lines if (m := re.search(r"\[ RUN      \] (\S+\.\S+)", line))]
    passed = {m.group(1) for line in lines if (m := re.search(r"\[       OK \] (\S+\.\S+?)[ ,]", line + " "))}
    skipped = {m.group(1) for line in lines if (m := re.search(r"\[  SKIPPED \] (\S+\.\S+?)[ ,]", line + " "))}
    return len(passed), [name for name in began if name not in passed and name not in skipped], len(skipped)


def pattern_of(name, options):
    """GoogleTest's pattern for a suite: of its tests, or those of them that --filter names."""
    suite = SUITES[name]
    if options.filter:
        foreign = ":".join(other.pattern.split(":")[0] for other in SUITES.values() if other is not suite)
        return options.filter + (":" if "-" in options.filter else ":-") + foreign
    return ":".join((suite.pattern, *suite.long_only)) if options.short else suite.pattern


def run_suite(name, suite, machine_files, options):
    """Boots one machine; (passed, failed, note)."""
    vmlinux, initramfs = machine_files
    log_path = os.path.join(options.output, f"{name}.log")
    with tempfile.TemporaryDirectory(prefix="annulus-hil-") as folder:
        peer = suite.peer(folder, options.build, os.path.join(options.output, f"{name}-devices.log"))
        requests = Requests(os.path.join(folder, "requests"), peer.answer)
        try:
            peer.start()
            devices = ["-chardev", f"socket,id=requests,path={folder}/requests", "-device", "pci-serial,chardev=requests",
                       *suite.devices, *peer.devices()]
            parameters = {"hil": name, "hil_filter": pattern_of(name, options), "hil_seconds": suite.seconds,
                          "hil_udev": int(suite.udev), "hil_long": int(not options.short)}
            lines, how = boot(vmlinux, initramfs, parameters, devices, log_path, suite.seconds + 60, peer.booted)
        finally:
            peer.close()
            requests.close()
    passed, bad, skipped = count(lines)
    warned = any("HIL: complaint:" in line and not (suite.complaint and suite.complaint in line) for line in lines)
    verdict = next((m for line in lines if (m := VERDICT.search(line))), None)
    notes = ([f"{skipped} skipped"] if skipped else []) + (["kernel warnings in its log"] if warned else [])
    failed = len(bad)
    if verdict is None:
        notes.append(how or "the machine ended without a verdict")
        failed = max(failed, 1)
    elif verdict.group(2) != "0" and failed == 0:
        notes.append(f"the test program ended with {verdict.group(2)}")
        failed = 1
    if passed + failed == 0:
        notes.append("no test ran")
        failed = 1
    if failed or options.verbose:
        print("\n".join(lines[-400:]))
    for test in bad:
        print(f"hil: failed: {test}")
    if failed:
        notes.append(os.path.relpath(log_path))
    return passed, failed, ", ".join(notes)


def prepare(names, options):
    """(vmlinux, initramfs) for these suites."""
    cache = KernelCache(options.cache, say)
    try:
        return assemble(names, options, cache)
    except HilError:
        if not cache.renew():
            raise
        return assemble(names, options, cache)


def assemble(names, options, cache):
    files = Initramfs(os.path.join(options.output, "root"))
    files.add_program(os.path.join(options.build, "hil_guest"), "hil/hil_guest")
    built = any(SUITES[name].built for name in names)
    for name in names:
        files.add_modules(name, cache.tree(built), cache.release, SUITES[name].modules)
    if any(SUITES[name].udev for name in names):
        files.add_udev(cache.udev())
    initramfs = os.path.join(options.output, "initramfs.cpio")
    files.pack(initramfs)
    return cache.vmlinux(), initramfs


def parse(arguments):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog="example: ./dev hil can usb")
    parser.add_argument("suites", nargs="*", default=["all"], metavar="SUITE", help=f"{', '.join(SUITES)}, all (default); short: "
                        "can and usb with shorter plans")
    parser.add_argument("--build", required=True, help="folder of the compiled programs (./dev hil sets it)")
    parser.add_argument("--filter", default="", metavar="PATTERN", help="only these tests, as GoogleTest's --gtest_filter")
    parser.add_argument("--verbose", action="store_true", help="print the machines' serial logs")
    options = parser.parse_args(arguments)
    unknown = [s for s in options.suites if s not in SUITES and s not in GROUPS]
    if unknown:
        parser.error(f"no suite {unknown[0]}: there are {', '.join([*SUITES, *GROUPS])}")
    options.short = options.suites == ["short"]
    options.build = os.path.abspath(options.build)
    options.output = os.path.join(ROOT, "build", "hil")
    options.cache = os.path.abspath(os.environ.get("ANNULUS_HIL_CACHE") or os.path.join(options.output, "cache"))
    return options


def main(arguments):
    options = parse(arguments)
    names = list(dict.fromkeys(name for asked in options.suites for name in GROUPS.get(asked, (asked,))))
    os.makedirs(options.output, exist_ok=True)
    # A signal ends the run as an exception does: machines and devices are stopped on the way out.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    rows = []
    try:
        machine_files = prepare(names, options)
    except HilError as error:
        say(str(error))
        rows = [(name, 0, 1, 0, "not run: no kernel") for name in names]
        names = []
    for name in names:
        begin = time.monotonic()
        say(f"boot {name}")
        try:
            passed, failed, note = run_suite(name, SUITES[name], machine_files, options)
        except HilError as error:
            passed, failed, note = 0, 1, str(error)
        rows.append((name, passed, failed, time.monotonic() - begin, note))
    print(f"\n{'suite':<12} {'passed':>7} {'failed':>7} {'time':>8}")
    for name, passed, failed, seconds, note in rows:
        print(f"{name:<12} {passed:>7} {failed:>7} {seconds:>6.0f} s  {note}")
    bad = sum(row[2] for row in rows)
    print(f"\n{sum(row[1] for row in rows)} passed, {bad} failed")
    shutil.rmtree(os.path.join(options.output, "root"), ignore_errors=True)
    return 1 if bad else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
