#!/usr/bin/python3
"""annulus rebuild: a visit through the console, all that is derived thrown away, and made again from the recordings."""

import json
import os
import signal
import sqlite3
import subprocess
import time

import annulus_cli
from annulus_cli import SLOW_BUILD
from console_station import StationTest

DERIVED = ("landmarks.json", "measurements.json", "model.json")


class Rebuild(StationTest):
    def rebuild(self, *arguments, status=0):
        """What became of every file: {(scan, name): what}."""
        done = self.run_program("rebuild", "--store", "station", "--json", "-", *arguments, timeout=600)
        self.assertEqual(done.returncode, status, done.stderr)
        return {(one["scan"], one["name"]): one["what"] for one in json.loads(done.stdout)["files"]}

    def contents(self, browser, scan):
        """The bytes of what is derived, by name."""
        found = {}
        for artefact in self.artefacts(browser, scan):
            if artefact["name"] in DERIVED:
                found[artefact["name"]] = self.gives(browser.get(f"/api/artefacts/{artefact['id']}", raw=True))
        return found

    def drop_derived(self):
        """Rows and files of everything derived, gone, by another program than ours."""
        connection = sqlite3.connect(self.path("station/annulus.db"))
        for name, in connection.execute("SELECT file FROM artefacts WHERE derived = 1").fetchall():
            os.remove(self.path(f"station/files/{name[:2]}/{name}"))
        with connection:
            connection.execute("DELETE FROM artefacts WHERE derived = 1")
        connection.close()

    def scanned_head(self, browser):
        """A customer's head, scanned by the simulated booth; (customer and consent, scan)."""
        who = self.customer(browser, "Ada Example", height_mm=1750)

        def booth():
            return self.gives(browser.get("/api/booth"))["status"] or {"state": "", "homed": False}

        self.wait_for(lambda: booth()["state"] == "IDLE", 60)
        if not booth()["homed"]:
            self.gives(browser.post("/api/booth/home"))
        self.wait_for(lambda: booth()["homed"] and booth()["state"] == "IDLE", 120)
        self.gives(browser.post("/api/booth/arm", {"customer_id": who[0], "consent_id": who[1], "profile": "head",
                                                   "height_mm": 1750}))
        ready = self.wait_for(lambda: (lambda now: now["state"] == "ARMED" and now["start_presses"] > 0 and now)(booth()), 60)
        self.gives(browser.post("/api/booth/start", {"version": ready["version"]}))
        scans = self.wait_for(lambda: self.gives(browser.get("/api/scans"))["scans"], 180)
        self.wait_for(lambda: self.is_fitted(browser, scans[0]["id"]), 300)
        return who, scans[0]["id"]

    def visit(self, browser):
        """A scan with a model, a design and a landmark set by hand, released."""
        if SLOW_BUILD:  # too slow for the booth's real time, and a head takes long to fit
            who = self.customer(browser, "Ada Example")
            scan = self.import_scan(browser, who, self.cylinder())
        else:
            _, scan = self.scanned_head(browser)
        style = self.gives(browser.get("/api/glasses/catalogue"))["styles"][0]["id"]
        self.gives(browser.post(f"/api/scans/{scan}/designs", {"title": "Sunday", "design": {"style": style}}))
        self.gives(browser.post(f"/api/scans/{scan}/release", {}))
        return scan

    def test_everything_derived_is_made_again_as_it_was(self):
        console, browser = self.start()
        browser.log_in("operator")
        scan = self.visit(browser)
        before = self.gives(browser.get(f"/api/scans/{scan}"))
        contents = self.contents(browser, scan)
        self.assertIn("model.json", contents)
        measured = browser.get(f"/api/scans/{scan}/measurements?language=en")
        designs = self.gives(browser.get(f"/api/scans/{scan}/designs"))
        self.assertEqual(console.stop()[1], 0)

        self.assertEqual({what for (_, name), what in self.rebuild().items() if name in DERIVED}, {"identical"})
        self.drop_derived()
        made = self.rebuild()
        self.assertEqual({name for (_, name), what in made.items() if what == "new"}, {*contents, "fit-report.json"})
        self.assertEqual(made[(scan, "summary")], "identical")
        self.assertEqual(made[(scan, "Sunday")], "kept")
        again = self.rebuild("--scan", scan)
        self.assertEqual({again[(scan, name)] for name in contents}, {"identical"}, "a second time changes nothing")
        self.assertEqual(json.loads(self.store("verify", "--json", "-").stdout)["problems"], [])

        console, browser = self.start()
        browser.log_in("operator")
        self.assertEqual(self.contents(browser, scan), contents, "the same bytes")
        self.assertEqual(browser.get(f"/api/scans/{scan}/measurements?language=en"), measured)
        self.assertEqual(self.gives(browser.get(f"/api/scans/{scan}/designs")), designs)
        after = self.gives(browser.get(f"/api/scans/{scan}"))
        for key in ("verdict", "summary", "model", "customer_id", "consent_id", "taken_ms"):
            self.assertEqual(after[key], before[key], key)
        self.assertTrue(after["summary"]["released"])

    def test_a_lost_or_damaged_file_is_made_again(self):
        console, browser = self.start()
        browser.log_in("operator")
        scan = self.import_scan(browser, self.customer(browser, "Ada Example"), self.cylinder())
        contents = self.contents(browser, scan)
        console.stop()
        connection = sqlite3.connect(self.path("station/annulus.db"))
        files = [name for name, in connection.execute("SELECT file FROM artefacts WHERE kind = 'model' OR kind = 'landmarks'"
                                                      " ORDER BY kind")]
        connection.close()
        self.damage(self.path(f"station/files/{files[0][:2]}/{files[0]}"))
        os.remove(self.path(f"station/files/{files[1][:2]}/{files[1]}"))
        made = self.rebuild()
        self.assertEqual((made[(scan, "landmarks.json")], made[(scan, "model.json")]), ("changed", "changed"))
        _, browser = self.start()
        browser.log_in("operator")
        self.assertEqual(self.contents(browser, scan), contents)

    def test_a_damaged_recording_is_named_and_the_rest_is_rebuilt(self):
        console, browser = self.start()
        browser.log_in("operator")
        who = self.customer(browser, "Ada Example")
        scans = [self.import_scan(browser, who, self.cylinder(seed=seed)) for seed in (1, 2, 3)]
        contents = self.contents(browser, scans[0])
        console.stop()
        self.damage(self.recording_of(scans[0]))
        os.remove(self.recording_of(scans[1]))
        done = self.run_program("rebuild", "--store", "station", timeout=600)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("2 of 3 scans could not be rebuilt", done.stderr)
        lines = done.stdout.splitlines()
        for scan, why in ((scans[0], "it is damaged"), (scans[1], "it is not there")):
            self.assertTrue(any(line.startswith(scan) and why in line for line in lines), done.stdout)
        self.assertTrue(any(line.startswith(scans[2]) and "identical" in line for line in lines), done.stdout)
        console, browser = self.start()
        browser.log_in("operator")
        self.assertEqual(self.contents(browser, scans[0]), contents, "what there was of it is as it was")

    def test_what_the_summary_lacks_is_filled_in(self):
        """A store of an earlier version did not know the size of its recordings."""
        console, browser = self.start()
        browser.log_in("operator")
        scan = self.import_scan(browser, self.customer(browser, "Ada Example"), self.cylinder())
        exported = self.gives(browser.get(f"/api/scans/{scan}"))["summary"]
        self.assertEqual(exported["levels"], 21)  # 200 mm of 10 mm, both ends
        technician = self.logged_in(console, "technician")
        listed = self.gives(technician.get("/api/technician/recordings"))["recordings"]
        self.assertEqual([(one["scan_id"], one["levels"], one["state"]) for one in listed], [(scan, 21, "kept")])
        document = self.gives(technician.get(f"/api/scans/{scan}/document?kind=recording", raw=True))
        self.assertEqual(listed[0]["bytes"], len(document))

    def test_killed_it_can_be_repeated_and_leaves_no_opened_file(self):
        console, browser = self.start()
        browser.log_in("operator")
        scan = self.import_scan(browser, self.customer(browser, "Ada Example"), self.cylinder())
        contents = self.contents(browser, scan)
        console.stop()
        start = time.monotonic()
        self.rebuild()
        whole = time.monotonic() - start
        for part in (0.2, 0.5, 0.8):
            process = subprocess.Popen([self.program, "rebuild", "--store", "station"], cwd=self.folder,
                                       stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                process.wait(timeout=part * whole)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
            process.wait()
            self.assertEqual({what for (_, name), what in self.rebuild().items() if name in contents}, {"identical"})
            left = [name for name in os.listdir("/dev/shm") if name.startswith(f"annulus-scratch-{os.geteuid()}-{process.pid}-")]
            self.assertEqual(left, [])
        _, browser = self.start()
        browser.log_in("operator")
        self.assertEqual(self.contents(browser, scan), contents)

    def test_a_breath_has_no_body_and_is_no_failure(self):
        self.succeeds("scan", "--profile", "breath", "--out", "breath.mcap", timeout=300)
        console, browser = self.start()
        browser.log_in("operator")
        answer = self.upload(browser, self.customer(browser, "Ada Example"), self.read("breath.mcap"))
        scan = self.job(browser, answer)["result"]["scan"]["id"]
        console.stop()
        self.assertEqual(self.rebuild(), {(scan, "summary"): "identical"})

    def test_an_empty_store_has_nothing_to_rebuild(self):
        console, _ = self.start()
        console.stop()
        self.assertEqual(self.succeeds("rebuild", "--store", "station"), "no recordings\n")


if __name__ == "__main__":
    annulus_cli.main()
