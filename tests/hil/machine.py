"""One emulated machine: QEMU's flags, its serial log, the guest's requests to the host, and its end whatever happens."""

import ctypes
import os
import re
import select
import signal
import socket
import subprocess
import threading
import time

from debian_kernel import HilError

# Always software emulation: where /dev/kvm exists in a nested machine, it may open and then hang the guest.
QEMU = ["qemu-system-x86_64", "-accel", "tcg", "-M", "pc", "-cpu", "max", "-m", "512", "-display", "none", "-monitor", "none",
        "-no-reboot", "-nodefaults"]
APPEND = "console=ttyS0 panic=-1 quiet mitigations=off nokaslr tsc=reliable"
LIBC = ctypes.CDLL(None)
VERDICT = re.compile(r"HIL: verdict (\S+) exit (\d+)")


def die_with_parent():
    """Runs in a child before its program starts: it is killed when this script is, even by SIGKILL."""
    LIBC.prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def spawn(command, **options):
    try:
        return subprocess.Popen(command, stdin=subprocess.DEVNULL, preexec_fn=die_with_parent, **options)
    except OSError as error:
        raise HilError(f"start {command[0]}: {error}: install the packages of cmake/packages.txt and build first") from error


def end(process):
    if process is not None and process.poll() is None:
        process.kill()
        process.wait()


class Requests:
    """The guest's requests to the host: one line in, one line (`ok …` or `error …`) out, on a serial port of its own."""

    def __init__(self, path, answer):
        self._answer = answer
        self._server = socket.socket(socket.AF_UNIX)
        self._server.bind(path)  # before QEMU starts: QEMU is the client
        self._server.listen(1)
        self._closing = False
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self):
        self._server.settimeout(60)
        try:
            connection, _ = self._server.accept()
        except OSError:
            return
        pending = b""
        with connection:
            while not self._closing:
                if not select.select([connection], [], [], 0.2)[0]:
                    continue
                try:
                    data = connection.recv(4096)
                except OSError:
                    return
                if not data:
                    return
                pending += data
                while b"\n" in pending:
                    line, pending = pending.split(b"\n", 1)
                    connection.sendall(self._reply(line.decode(errors="replace").strip()).encode() + b"\n")

    def _reply(self, request):
        try:
            return f"ok {self._answer(request) or ''}".strip()
        except (HilError, OSError, ValueError, LookupError) as error:
            return "error " + str(error).replace("\n", " ")

    def close(self):
        self._closing = True
        self._server.close()
        self._thread.join(timeout=5)


def boot(vmlinux, initramfs, parameters, devices, log_path, seconds, booted):
    """Runs a machine to its end or for `seconds`; `booted` is called when QEMU has started. The lines of the serial log, and how it
    ended (empty: by itself)."""
    append = " ".join([APPEND, *(f"{name}={value}" for name, value in parameters.items())])
    command = [*QEMU, "-serial", "stdio", *devices, "-kernel", vmlinux, "-initrd", initramfs, "-append", append]
    deadline = time.monotonic() + seconds
    how = ""
    with open(log_path, "wb") as log:
        qemu = spawn(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        try:
            booted()
            tail = b""
            while True:
                left = deadline - time.monotonic()
                if left <= 0:
                    how = f"killed after {seconds} s"
                    break
                if not select.select([qemu.stdout], [], [], min(left, 1.0))[0]:
                    continue
                data = os.read(qemu.stdout.fileno(), 65536)
                if not data:
                    break
                log.write(data)
                log.flush()
                # The machine may hang in switching off: a verdict is the end, with a little time for that.
                tail = (tail + data)[-4096:]
                if VERDICT.search(tail.decode(errors="replace")):
                    deadline = min(deadline, time.monotonic() + 10)
        finally:
            end(qemu)
    with open(log_path, encoding="utf-8", errors="replace") as f:
        lines = [line.rstrip("\r\n") for line in f]
    if any(VERDICT.search(line) for line in lines):
        how = ""
    return lines, how
