#!/usr/bin/python3
"""The console's jobs as they run in a shop: `annulus serve` starts our own commands as processes, and what they give is
what the commands give by hand. And a calibration that is accepted, up to the scan of the next customer through boothd."""

import json
import os
import subprocess
import time

import annulus_cli
from annulus_cli import ProgramTest, TIME_FACTOR
from console_client import Browser, Console

# As few levels as the ring can, of the targets and of the body.
CONFIG = """
[profile.target]
pitch_mm = 20
speed_mm_s = 300
[profile.belt]
z_top_mm = 1100
z_bottom_mm = 1000
pitch_mm = 5
speed_mm_s = 100
[sim]
ring_errors = 1
ring_seed = 5
"""
TARGETS = ("cylinder:radius_mm=150,u_mm=0.02,height_mm=1300 + cylinder:radius_mm=70,u_mm=0.02,height_mm=1300 + "
           "verify:cylinder:radius_mm=110,u_mm=0.02,height_mm=1300")
# Causes that a machine too busy for real time brings; that the booth stops then is right, and tested in virtual time.
TIMING = {"host_late", "host_hang", "thread_dead", "following_error", "axis_link", "axis_fault", "sensor_lost"}
MOST_TRIES = 5


class ConsoleTest(ProgramTest):
    def start(self, *arguments, **options):
        console = Console(self.program, self.folder, *arguments, **options)
        self.addCleanup(console.close)
        return console

    def browser(self, console, user):
        browser = Browser(console.port)
        browser.log_in(user)
        return browser

    def wait_for(self, what, seconds=60):
        """What `what()` gives, once that is something."""
        end = time.monotonic() + seconds * TIME_FACTOR
        while True:
            found = what()
            if found:
                return found
            self.assertLess(time.monotonic(), end, "it took too long")
            time.sleep(0.05)


class Jobs(ConsoleTest):
    def test_ranking_of_frames_is_that_of_the_command(self):
        self.write("head.toml", '[sim]\nsubject = "head"\nseed = 4\n')
        self.succeeds("scan", "--config", "head.toml", "--profile", "head", "--out", "head.mcap")
        operator = self.browser(self.start(), "operator")
        scan = operator.bring_in(self.read("head.mcap"))
        job = operator.wait_job(operator.asks(f"/api/scans/{scan}/glasses/rank", {"top": 3}))
        self.assertEqual((job["kind"], job["subject"]), ("glasses_rank", scan))
        self.succeeds("fit", "head.mcap", "--out", "head.json")
        by_hand = self.succeeds_json("glasses", "rank", "head.json", "--top", "3")["frames"]
        frames = job["result"]["frames"]
        self.assertEqual(len(frames), 3)
        for ours, theirs in zip(frames, by_hand):
            self.assertEqual({key: ours[key] for key in theirs}, theirs)
            self.assertEqual(ours["design"]["style"], theirs["style"])

    def test_replay_opens_steps_runs_and_fits(self):
        self.write("booth.toml", CONFIG)
        self.succeeds("scan", "--config", "booth.toml", "--profile", "belt", "--out", "belt.mcap")
        console = self.start()
        scan = self.browser(console, "operator").bring_in(self.read("belt.mcap"))
        developer = self.browser(console, "technician")
        opened = developer.asks("/api/replay/open", {"scan": scan})
        levels = self.succeeds_json("inspect", "belt.mcap")["levels"]
        self.assertEqual((opened["levels"], opened["sensors"]), (levels, 180))
        at = f"/api/replay/{opened['replay_id']}"
        for step in (0, 1, levels - 1):
            status, level = developer.get(f"{at}/level/{step}")
            self.assertEqual((status, level["n"]), (200, step))
            self.assertTrue(level["frames"], "the raw bytes")
        self.assertEqual(developer.get(f"{at}/level/{levels}")[0], 404)
        result = developer.wait_job(developer.asks(f"{at}/run"))["result"]
        by_hand = self.succeeds_json("replay", "belt.mcap")
        for key in ("identical", "whole", "recorded_levels", "replayed_levels", "identical_levels", "differing"):
            self.assertEqual(result[key], by_hand[key], key)
        self.assertIs(result["identical"], True)
        fit = developer.wait_job(developer.asks(f"{at}/fit", {"options": {"method": "uniform"}}))["result"]
        self.succeeds("fit", "belt.mcap", "--out", "belt.json", "--report", "report.json", "--method", "uniform")
        self.assertEqual(fit["coefficients"], self.read_json("report.json")["coefficients"])
        self.assertTrue(fit["model_id"] and fit["residuals_png"])

    def test_a_job_that_fails_says_what_its_command_said(self):
        operator = self.browser(self.start(), "operator")
        customer, consent = operator.somebody()
        status, job = operator.request("POST", f"/api/scans/import?customer_id={customer}&consent_id={consent}",
                                       b"level,z_mm\n1,2\n", headers={"Content-Type": "application/octet-stream"})
        self.assertEqual(status, 200, job)
        ended = self.wait_for(lambda: [one for one in operator.get("/api/jobs")[1]["jobs"] if one["state"] == "failed"])
        self.write("points.csv", "level,z_mm\n1,2\n")
        said = self.run_program("import", "points.csv", "--out", "scan.mcap").stderr
        self.assertIn(ended[0]["error"]["seen"], said)


class Calibration(ConsoleTest):
    """A station of a configuration that names no calibration: boothd and the console beside each other."""

    def setUp(self):
        super().setUp()
        self.write("booth.toml", CONFIG)
        recordings, socket = self.path("station/recordings"), self.path("s")
        boothd = subprocess.Popen([self.program, "boothd", "--config", "booth.toml", "--socket", socket, "--recordings", recordings],
                                  cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.end, boothd)
        self.assertTrue(boothd.stdout.readline().startswith("serving the booth on "))
        self.console = self.start("--socket", socket, config=self.path("booth.toml"))
        Browser(self.console.port).set_up()
        self.user, self.page = "operator", self.browser(self.console, "operator")
        self.customer, self.consent = self.page.somebody()

    @staticmethod
    def end(process):
        process.terminate()
        process.wait()
        process.stdout.close()
        process.stderr.close()

    def turn(self, user):
        """Only one session works with the booth: whoever is there logs out."""
        if user != self.user:
            self.page.asks("/api/logout")
            self.user, self.page = user, self.browser(self.console, user)

    def status(self):
        answer = self.page.get("/api/booth")[1]
        return answer["status"] if answer["connected"] else None

    def wait_state(self, *states):
        """The booth's status once it is in one of these, or has a fault."""
        def reached():
            status = self.status()
            return status if status and not status["job"] and status["state"] in (*states, "FAULT") else None
        return self.wait_for(reached, 120)

    def visits(self):
        return [scan["id"] for scan in self.page.get(f"/api/customers/{self.customer}")[1]["visits"]]

    def try_to_scan(self):
        """Home, arm, the start key that the simulated operator presses, start; whether a whole scan came of it."""
        state = self.wait_state("IDLE")["state"]
        if state == "FAULT":
            self.page.asks("/api/booth/acknowledge")
            self.wait_state("IDLE")
        if not self.status()["homed"]:
            self.page.asks("/api/booth/home")
            self.wait_for(lambda: self.status()["homed"] or self.status()["state"] == "FAULT", 120)
        before = set(self.visits())
        self.page.asks("/api/booth/arm", {"customer_id": self.customer, "consent_id": self.consent, "profile": "belt"})
        armed = self.wait_state("ARMED")
        if armed["state"] == "FAULT":
            return None
        pressed = self.wait_for(lambda: self.status()["start_presses"] > armed["start_presses"] and self.status(), 60)
        status, answer = self.page.post("/api/booth/start", {"version": pressed["version"]})
        if status != 200:
            return None
        self.wait_state("IDLE")
        if self.status()["scan"]["error"]:
            return None
        return self.wait_for(lambda: set(self.visits()) - before).pop()

    def scan(self):
        """A scan's id; tried again where the machine was too busy for real time."""
        self.turn("operator")
        for _ in range(MOST_TRIES):
            scan = self.try_to_scan()
            if scan:
                return scan
            causes = {cause["code"] for cause in self.status()["causes"]}
            self.assertTrue(causes <= TIMING, causes)
        return self.fail("the machine was too busy every time")

    def calibration_of(self, scan):
        """The hash of the calibration that a scan carries; "" of an ideal ring."""
        self.turn("technician")
        job = self.page.asks(f"/api/technician/recordings/{scan}/inspect")
        return self.page.wait_job(job)["result"]["calibration"]

    def calibrate(self):
        """Every step of the guide, then the solve; its result."""
        self.turn("technician")
        run = self.page.asks("/api/calibration/begin", {"target": TARGETS})
        for step in range(len(run["steps"])):
            self.page.asks("/api/calibration/take", {"step": step})
            ended = self.wait_for(lambda: self.not_scanning(), 120)
            self.assertEqual(ended["steps"][step]["state"], "taken", ended)
        return self.page.wait_job(self.page.asks("/api/calibration/solve"))["result"]

    def not_scanning(self):
        run = self.page.get("/api/calibration")[1]["run"]
        return run if run["state"] != "scanning" else None

    def test_one_that_is_accepted_is_carried_by_the_next_scan(self):
        self.assertEqual(self.calibration_of(self.scan()), "", "nobody has calibrated the ring yet")
        self.assertIsNone(self.page.get("/api/calibration")[1]["current"])
        result = self.calibrate()
        self.assertIs(result["passed"], True, result["limits"])
        self.assertEqual(len(result["plots"]["after_mm"]), 180)
        accepted = self.page.asks("/api/calibration/accept", {"confirm": True})
        self.assertIs(accepted["in_force"], True)
        name = accepted["name"]
        kept = self.page.get(f"/api/calibration/report/{name}?file=CAL.json")[1]
        self.assertEqual(self.page.get("/api/calibration")[1]["current"]["name"], name)
        with open(self.path("station/recordings/calibration.json"), encoding="utf-8") as f:
            self.assertEqual(json.load(f), kept)
        self.assertEqual(os.stat(self.path("station/recordings/calibration.json")).st_mode & 0o777, 0o644,
                         "boothd may be another user")
        self.assertEqual(self.calibration_of(self.scan()), kept["hash"], "boothd was not even started again")


if __name__ == "__main__":
    annulus_cli.main()
