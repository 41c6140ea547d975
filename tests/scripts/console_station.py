"""A station for whole-program tests: `annulus serve --simulated` in the test's folder, with customers and their scans."""

import os
import sqlite3
import time

from annulus_cli import EllipticCylinder, ProgramTest, TIME_FACTOR
from console_client import Browser, Console


class StationTest(ProgramTest):
    """The station lies in the folder `station`; its store is the same folder."""

    def start(self, *arguments):
        console = Console(self.program, self.folder, *arguments)
        self.addCleanup(console.close)
        return console, Browser(console.port)

    def logged_in(self, console, user):
        browser = Browser(console.port)
        browser.log_in(user)
        return browser

    def wait_for(self, what, seconds=30):
        """The first answer of `what()` that is true."""
        end = time.monotonic() + seconds * TIME_FACTOR
        while True:
            answer = what()
            if answer:
                return answer
            self.assertLess(time.monotonic(), end, "it took too long")
            time.sleep(0.05)

    def gives(self, answer, status=200):
        """The body of an answer that must have this status."""
        self.assertEqual(answer[0], status, answer[1])
        return answer[1]

    def refuses(self, answer, status, *naming, field=None):
        """An error with all of its parts, which says every text of `naming`."""
        error = self.gives(answer, status)
        said = error["error"]
        for part in ("attempted", "seen", "advice"):
            self.assertTrue(said[part], error)
        for text in naming:
            self.assertIn(text, " ".join(said.values()), error)
        if field is not None:
            self.assertEqual(error.get("field"), field, error)
        return said

    def job(self, browser, answer, state="done", seconds=120):
        """The job that `answer` has started, once it has come to `state`."""
        job = self.gives(answer)

        def ended():
            now = self.gives(browser.get(f"/api/jobs/{job['id']}"))
            return now if now["state"] in ("done", "failed", "cancelled") else None

        now = self.wait_for(ended, seconds)
        self.assertEqual(now["state"], state, now)
        return now

    def customer(self, browser, name, **fields):
        """(customer's id, id of a consent to everything)."""
        made = self.gives(browser.post("/api/customers", {"name": name, **fields}))
        version = self.gives(browser.get("/api/consent-text?language=en"))["version"]
        consent = self.gives(browser.post(f"/api/customers/{made['id']}/consents", {
            "purposes": ["measure", "glasses"], "text_version": version, "language": "en", "agreed": True}))
        return made["id"], consent["id"]

    def upload(self, browser, who, data):
        return browser.post(f"/api/scans/import?customer_id={who[0]}&consent_id={who[1]}", data,
                            headers={"Content-Type": "application/octet-stream"})

    def import_scan(self, browser, who, data):
        """The id of the scan, once it has a model and what is measured of it."""
        scan = self.job(browser, self.upload(browser, who, data))["result"]["scan"]["id"]
        self.wait_for(lambda: self.is_fitted(browser, scan), 120)
        return scan

    def is_fitted(self, browser, scan):
        """The last file that a fit leaves is there, and nothing works on it any more."""
        jobs = self.gives(browser.get("/api/jobs"))["jobs"]
        busy = any(job["subject"] == scan and job["state"] in ("waiting", "running") for job in jobs)
        return not busy and any(one["kind"] == "landmarks" for one in self.artefacts(browser, scan))

    def artefacts(self, browser, scan):
        return self.gives(browser.get(f"/api/scans/{scan}"))["artefacts"]

    def cylinder(self, **options):
        """A range table of an elliptic cylinder, as bytes."""
        return EllipticCylinder(height=200.0).csv(**options).encode()

    def store(self, *arguments, **options):
        """`annulus store …` on the station's store."""
        return self.run_program("store", *arguments, "--store", "station", **options)

    def database(self):
        """The store's database, opened by another program."""
        connection = sqlite3.connect(self.path("station/annulus.db"), isolation_level=None, timeout=0)
        self.addCleanup(connection.close)
        return connection

    def recording_of(self, scan):
        """The file of a scan's recording in the store."""
        connection = sqlite3.connect(self.path("station/annulus.db"))
        name, = connection.execute("SELECT recording FROM scans WHERE id = ?", (scan,)).fetchone()
        connection.close()
        return self.path(f"station/files/{name[:2]}/{name}")

    def damage(self, path):
        """One bit in the middle of a file, flipped."""
        with open(path, "r+b") as f:
            f.seek(os.path.getsize(path) // 2)
            byte = f.read(1)
            f.seek(-1, os.SEEK_CUR)
            f.write(bytes([byte[0] ^ 1]))
