"""A client of the console for whole-program tests: what the page does, with Python's own ssl and http.client."""

import http.client
import json
import os
import re
import signal
import ssl
import subprocess
import time

from annulus_cli import TIME_FACTOR

PASSWORDS = {"operator": "tidal crumbs vexed orbit", "technician": "gravel otter plinth 27", "admin": "nine wet stones hum"}


class Console:
    """`annulus serve --simulated` on a free port, in a folder of its own; its accounts are made at the first start."""

    def __init__(self, program, folder, *arguments):
        station = os.path.join(folder, "station")
        if not os.path.isdir(station):
            password_file = os.path.join(folder, "passwords")
            with open(password_file, "w", encoding="utf-8") as f:
                f.writelines(f"{name} {password}\n" for name, password in PASSWORDS.items())
            arguments = ("--password-file", password_file, *arguments)
        self.started = time.monotonic()
        self.process = subprocess.Popen(
            [program, "serve", "--simulated", "--port", "0", "--folder", station, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.greeting = ""
        while "Ctrl-C ends it." not in self.greeting:
            line = self.process.stdout.readline()
            if not line:
                raise RuntimeError(f"serve ended: {self.process.wait()}: {self.process.stderr.read()}")
            self.greeting += line
        self.ready_after = time.monotonic() - self.started
        self.port = int(re.search(r"https://localhost:(\d+)", self.greeting).group(1))

    def stop(self):
        """SIGTERM; the seconds until the end, and the exit code."""
        start = time.monotonic()
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(timeout=30 * TIME_FACTOR)
        return time.monotonic() - start, code

    def kill(self):
        self.process.kill()
        self.process.wait()

    def close(self):
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(timeout=10 * TIME_FACTOR)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.process.stdout.close()
        self.process.stderr.close()


class Browser:
    """Keeps cookie and CSRF token, and sends what a page of ours sends."""

    def __init__(self, port, host="localhost"):
        self.port = port
        self.origin = f"https://{host}:{port}"
        self.host = f"{host}:{port}"
        self.cookie = ""
        self.csrf = ""
        self.headers = {}

    def request(self, method, path, body=None, headers=None, raw=False):
        """(status, parsed JSON or text; the bytes if `raw`). `headers` replace ours; a value of None leaves one out."""
        context = ssl.create_default_context()
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE  # its own authority; that it fits is tested apart
        connection = http.client.HTTPSConnection("127.0.0.1", self.port, context=context, timeout=30 * TIME_FACTOR)
        send = {"Host": self.host, "Sec-Fetch-Site": "same-origin"}
        if self.cookie:
            send["Cookie"] = f"__Host-annulus={self.cookie}"
        data = b""
        if method == "POST":
            data = body if isinstance(body, bytes) else json.dumps(body or {}).encode()
            send.update({"Origin": self.origin, "Content-Type": "application/json", "X-CSRF-Token": self.csrf})
        send.update(headers or {})
        send = {name: value for name, value in send.items() if value is not None}
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for name, value in send.items():
            connection.putheader(name, value)
        if "Content-Length" not in send:
            connection.putheader("Content-Length", str(len(data)))
        connection.endheaders(data)
        response = connection.getresponse()
        self.headers = dict(response.getheaders())
        content = response.read()
        connection.close()
        cookie = re.match(r"__Host-annulus=([0-9a-f]*)", self.headers.get("Set-Cookie", ""))
        if cookie:
            self.cookie = cookie.group(1)
        if raw and response.status == 200:
            return response.status, content
        text = content.decode("utf-8", "replace")
        answer = json.loads(text) if self.headers.get("Content-Type", "").startswith("application/json") else text
        if isinstance(answer, dict) and "csrf" in answer:
            self.csrf = answer["csrf"]
        return response.status, answer

    def get(self, path, **options):
        return self.request("GET", path, **options)

    def post(self, path, body=None, **options):
        return self.request("POST", path, body, **options)

    def log_in(self, user):
        self.get("/api/session")
        status, answer = self.post("/api/login", {"user": user, "password": PASSWORDS[user]})
        if status != 200:
            raise AssertionError(f"log in as {user}: {status} {answer}")
        return answer
