"""What stands at the other end of the guest's buses: our device models as processes of the host."""

import os
import select
import socket
import subprocess
import termios
import threading
import time
import tty

from debian_kernel import HilError
from machine import die_with_parent, end

PATIENCE = 30  # s, for a program to answer or a socket to appear


class NoPeer:
    """A suite whose buses are inside the guest."""

    def __init__(self, folder, build, log_path):
        self.folder = folder  # for sockets; gone after the run
        self.build = build
        self.log_path = log_path  # what the device programs complain about

    def start(self):
        """Before QEMU starts."""

    def devices(self):
        """QEMU's flags."""
        return []

    def booted(self):
        """When QEMU runs."""

    def answer(self, request):
        """Carries out a request of the guest; the text of its reply."""
        if request.startswith("echo "):
            return request.removeprefix("echo ")
        raise HilError(f"unknown request '{request}'")

    def close(self):
        """Whatever happened before."""


class Program:
    """A device program: takes one command a line, answers each with one line, `ok …` or `error …`."""

    def __init__(self, command, log_path):
        self.command = command
        self.pending = b""
        try:
            with open(log_path, "ab") as log:
                self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log,
                                                preexec_fn=die_with_parent)
        except OSError as error:
            raise HilError(f"start {command[0]}: {error}: build the target hil_targets first") from error

    def ask(self, line):
        try:
            self.process.stdin.write(line.encode() + b"\n")
            self.process.stdin.flush()
        except OSError as error:
            raise HilError(f"{line}: {os.path.basename(self.command[0])} is gone: {error}") from error
        return self.read(line)

    def read(self, what, good="ok"):
        """What the program answers after `good`; whatever else it says is skipped."""
        name = os.path.basename(self.command[0])
        deadline = time.monotonic() + PATIENCE
        while True:
            while b"\n" in self.pending:
                line, self.pending = self.pending.split(b"\n", 1)
                answer = line.decode(errors="replace").strip()
                if answer.startswith(good):
                    return answer.removeprefix(good).strip()
                if answer.startswith("error"):
                    raise HilError(f"{what}: {name} says '{answer}'")
            output = self.process.stdout.fileno()
            if not select.select([output], [], [], max(0.0, deadline - time.monotonic()))[0]:
                raise HilError(f"{what}: {name} says nothing for {PATIENCE} s")
            data = os.read(output, 4096)
            if not data:
                raise HilError(f"{what}: {name} has ended")
            self.pending += data

    def kill(self):
        end(self.process)


def connect(path):
    """A connection to a socket that QEMU makes."""
    deadline = time.monotonic() + PATIENCE
    while True:
        connection = socket.socket(socket.AF_UNIX)
        try:
            connection.connect(path)
            return connection
        except OSError as error:
            connection.close()
            if time.monotonic() > deadline:
                raise HilError(f"connect to the machine at {path}: {error}") from error
            time.sleep(0.05)


class SerialCable:
    """Joins a serial port of the machine (a socket of QEMU's) to a terminal of the host. For the machine's USB adapter,
    plugging the cable is plugging the adapter."""

    def __init__(self, socket_path, terminal):
        self.socket_path = socket_path
        self.terminal = os.open(terminal, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.terminal, termios.TCSANOW)
        self.connection = None
        self.thread = None

    def plug(self):
        if self.connection is None:
            self.connection = connect(self.socket_path)
            self.thread = threading.Thread(target=self._carry, args=(self.connection,), daemon=True)
            self.thread.start()

    def _carry(self, connection):
        other = {connection.fileno(): self.terminal, self.terminal: connection.fileno()}
        while True:
            ready, _, _ = select.select(list(other), [], [], 0.5)
            for source in ready:
                try:
                    data = os.read(source, 4096)
                    if not data:
                        return
                    os.write(other[source], data)
                except OSError:
                    return
            if connection.fileno() < 0:
                return

    def unplug(self):
        if self.connection is not None:
            try:
                self.connection.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass  # the machine was faster
            self.thread.join(timeout=5)
            self.connection.close()
            self.connection = None

    def close(self):
        self.unplug()
        os.close(self.terminal)


class UsbBoards(NoPeer):
    """The ring's twelve boards on one USB controller, all served by one program.

    Requests: `usb unplug I`, `usb plug I`, `usb status I` (answered by the program), `usb kill` (SIGKILL), `usb start`.
    """

    BOARDS = 12

    def __init__(self, *places):
        super().__init__(*places)
        self.program = None

    def _socket(self, board):
        return os.path.join(self.folder, f"r{board}")

    def start(self):
        command = [os.path.join(self.build, "usbredir_ring")]
        for board in range(self.BOARDS):
            command += ["--socket", self._socket(board)]  # QEMU makes them; the program waits for them
        self.program = Program(command, self.log_path)

    def devices(self):
        flags = ["-device", f"qemu-xhci,id=x,p2={self.BOARDS},p3={self.BOARDS}"]
        for board in range(self.BOARDS):
            flags += ["-chardev", f"socket,id=r{board},path={self._socket(board)},server=on,wait=off",
                      "-device", f"usb-redir,chardev=r{board},bus=x.0,port={board + 1}"]
        return flags

    def answer(self, request):
        if request == "usb kill":
            self.program.kill()
            return ""
        if request == "usb start":
            self.start()
            return ""
        if request.startswith("usb "):
            return self.program.ask(request.removeprefix("usb "))
        return super().answer(request)

    def close(self):
        if self.program is not None:
            self.program.kill()


class AxisDrives(NoPeer):
    """Two simulated drives: one on the machine's second serial port, one behind its USB adapter.

    Requests: `axis state|stall|resume I` (answered by the program), `adapter plug`, `adapter unplug`.
    """

    DRIVES = ("rtu", "ftdi")

    def __init__(self, *places):
        super().__init__(*places)
        self.program = None
        self.cables = {}

    def _socket(self, name):
        return os.path.join(self.folder, name)

    def start(self):
        self.program = Program([os.path.join(self.build, "axis_server"), str(len(self.DRIVES))], self.log_path)
        terminals = self.program.read("start", "ready").split()
        self.cables = {name: SerialCable(self._socket(name), t) for name, t in zip(self.DRIVES, terminals, strict=True)}

    def devices(self):
        socket_of = {name: f"socket,id={name},path={self._socket(name)},server=on,wait=off" for name in self.DRIVES}
        return ["-chardev", socket_of["rtu"], "-serial", "chardev:rtu", "-device", "qemu-xhci,id=x", "-chardev", socket_of["ftdi"],
                "-device", "usb-serial,chardev=ftdi,bus=x.0,serial=A180"]

    def booted(self):
        for cable in self.cables.values():
            cable.plug()

    def answer(self, request):
        if request == "adapter plug":
            self.cables["ftdi"].plug()
            return ""
        if request == "adapter unplug":
            self.cables["ftdi"].unplug()
            return ""
        if request.startswith("axis "):
            return self.program.ask(request.removeprefix("axis "))
        return super().answer(request)

    def close(self):
        for cable in self.cables.values():
            cable.close()
        if self.program is not None:
            self.program.kill()
