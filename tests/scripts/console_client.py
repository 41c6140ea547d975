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
    """`annulus serve` on a free port, with its things in the folder's `station`: simulated with the three accounts, or of
    a `config` and without an account yet."""

    def __init__(self, program, folder, *arguments, config=None):
        station = ["--config", config, "--allow-root"] if config else self.simulated(folder)
        self.started = time.monotonic()
        self.process = subprocess.Popen(
            [program, "serve", *station, "--port", "0", "--folder", os.path.join(folder, "station"), *arguments],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.greeting = ""
        while "Ctrl-C ends it." not in self.greeting:
            line = self.process.stdout.readline()
            if not line:
                raise RuntimeError(f"serve ended: {self.process.wait()}: {self.process.stderr.read()}")
            self.greeting += line
        self.ready_after = time.monotonic() - self.started
        self.port = int(re.search(r"https://localhost:(\d+)", self.greeting).group(1))

    @staticmethod
    def simulated(folder):
        if os.path.isdir(os.path.join(folder, "station")):
            return ["--simulated"]  # it has its accounts
        password_file = os.path.join(folder, "passwords")
        with open(password_file, "w", encoding="utf-8") as f:
            f.writelines(f"{name} {password}\n" for name, password in PASSWORDS.items())
        return ["--simulated", "--password-file", password_file]

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

    def asks(self, path, body=None):
        """POST that has to succeed; its answer."""
        status, answer = self.post(path, body)
        if status != 200:
            raise AssertionError(f"POST {path}: {status} {answer}")
        return answer

    def set_up(self):
        """The first admin of a new station, and the other two accounts."""
        self.get("/api/session")
        self.asks("/api/setup", {"user": "admin", "password": PASSWORDS["admin"]})
        self.log_in("admin")
        for name in ("technician", "operator"):
            self.asks("/api/users", {"name": name, "role": name, "password": PASSWORDS[name]})

    def somebody(self):
        """A customer who has agreed to be measured; (customer, consent)."""
        customer = self.asks("/api/customers", {"name": "Jane Test"})["id"]
        version = self.get("/api/consent-text?language=en")[1]["version"]
        consent = {"purposes": ["measure", "glasses"], "text_version": version, "language": "en", "agreed": True}
        return customer, self.asks(f"/api/customers/{customer}/consents", consent)["id"]

    def wait_job(self, job, seconds=240):
        """The job once it has ended; it has to be done."""
        end = time.monotonic() + seconds * TIME_FACTOR
        while job["state"] in ("waiting", "running"):
            if time.monotonic() > end:
                raise AssertionError(f"a job does not end: {job}")
            time.sleep(0.1)
            job = self.get(f"/api/jobs/{job['id']}")[1]
        if job["state"] != "done":
            raise AssertionError(f"a job has not succeeded: {job}")
        return job

    def bring_in(self, recording):
        """A recording's bytes, taken in for a new customer and fitted; the scan's id."""
        customer, consent = self.somebody()
        status, job = self.request("POST", f"/api/scans/import?customer_id={customer}&consent_id={consent}", recording,
                                   headers={"Content-Type": "application/octet-stream"})
        if status != 200:
            raise AssertionError(f"import: {status} {job}")
        scan = self.wait_job(job)["result"]["scan"]["id"]
        for job in self.get("/api/jobs")[1]["jobs"]:
            if job["kind"] == "fit" and job["subject"] == scan:
                self.wait_job(job)
        return scan
