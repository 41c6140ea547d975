"""A client of boothd's socket written from docs/wire_protocol.md alone: u32 length, JSON."""

import json
import socket
import struct
import time


class Refused(Exception):
    """boothd's error of an order."""


class BoothSocket:
    def __init__(self, path, patience=60.0):
        self.patience = patience
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(patience)
        deadline = time.monotonic() + patience
        while True:
            try:
                self.socket.connect(path)
                break
            except (FileNotFoundError, ConnectionRefusedError):
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.02)
        self.buffer = b""
        self.last_id = 0
        self.status = None
        self.results = []
        self.levels = []

    def close(self):
        self.socket.close()

    def send(self, kind, **fields):
        self.last_id += 1
        text = json.dumps({"v": 1, "id": self.last_id, "type": kind, **fields}).encode()
        self.socket.sendall(struct.pack("<I", len(text)) + text)
        return self.last_id

    def _take(self, count):
        while len(self.buffer) < count:
            more = self.socket.recv(65536)
            if not more:
                raise EOFError("boothd closed the connection")
            self.buffer += more
        taken, self.buffer = self.buffer[:count], self.buffer[count:]
        return taken

    def receive(self):
        message = json.loads(self._take(struct.unpack("<I", self._take(4))[0]))
        assert message["v"] == 1, message
        if message["type"] == "status":
            self.status = message
        elif message["type"] == "result":
            self.results.append(message)
        elif message["type"] == "level":
            self.levels.append(message)
        return message

    def ask(self, kind, **fields):
        """Sends and waits for the answer."""
        number = self.send(kind, **fields)
        while True:
            message = self.receive()
            if message.get("id") != number:
                continue
            if message["type"] == "reply" and not message["ok"]:
                error = message["error"]
                raise Refused(f"{error['attempted']}: {error['seen']}: {error['advice']}")
            return message

    def hello(self, role="operator", control=True):
        welcome = self.ask("hello", role=role, control=control, client="test")
        while self.status is None:
            self.receive()
        return welcome

    def wait(self, wanted, what):
        """Reads until a status is as wanted."""
        deadline = time.monotonic() + self.patience
        while not wanted(self.status):
            if time.monotonic() > deadline:
                raise TimeoutError(f"{what}: {self.status}")
            self.receive()
        return self.status

    def wait_state(self, *states):
        return self.wait(lambda s: s["state"] in states and s["job"] == "", f"no {states}")
