#!/usr/bin/python3
"""drift and check on tables of ranges made here: a smooth vase with noise, and a column, seen by an ideal ring."""

import fcntl
import json
import math
import os
import random

import annulus_cli
from annulus_cli import ProgramTest

RING_MM = 600.0
SENSOR = 47


def table(range_of, seed, levels=70, pitch_mm=10.0):
    """Rows of one sweep; range_of(theta, z) in mm."""
    dice = random.Random(seed)
    yield "# R_mm=600"
    yield "level,z_mm,sensor,theta_deg,range_mm,t_s,sweep"
    for level in range(levels):
        z = 1000.0 - pitch_mm * level
        for sensor in range(180):
            seen = range_of(math.radians(2 * sensor), z, sensor) + dice.gauss(0.0, 0.3)
            yield f"{level},{z},{sensor},{2 * sensor},{seen:.4f},{level / 30:.4f},0"


def vase(seed, drift_mm=0.0):
    dice = random.Random(1000 + seed)
    wide, turn = dice.uniform(110, 160), dice.uniform(0, 6.28)

    def range_of(theta, z, sensor):
        radius = wide * (1 + 0.15 * math.cos(2 * (theta - turn)) + 0.05 * math.cos(3 * theta + z / 90) + 0.1 * math.sin(z / 150))
        return RING_MM - radius + (drift_mm if sensor == SENSOR else 0.0)

    return range_of


def column(radius_mm, x_mm=40.0, y_mm=-60.0, longer_mm=0.0):
    def range_of(theta, z, sensor):
        along = RING_MM - (x_mm * math.cos(theta) + y_mm * math.sin(theta))
        across = -x_mm * math.sin(theta) + y_mm * math.cos(theta)
        return along - math.sqrt(radius_mm**2 - across**2) + longer_mm + (0.9 if sensor == SENSOR and longer_mm else 0.0)

    return range_of


class Drift(ProgramTest):
    def scan(self, name, range_of, seed):
        with open(self.path(name + ".csv"), "w", encoding="utf-8") as file:
            file.write("\n".join(table(range_of, seed)) + "\n")
        self.succeeds("import", self.path(name + ".csv"), "--out", self.path(name + ".mcap"))
        return self.path(name + ".mcap")

    def test_two_at_once_do_not_lose_what_the_other_has_added(self):
        scan, history = self.scan("one", vase(1), 1), self.path("ring.json")
        folder = os.open(self.folder, os.O_RDONLY)
        self.addCleanup(os.close, folder)
        fcntl.flock(folder, fcntl.LOCK_EX)  # as another run of it does
        done = self.run_program("drift", scan, "--history", history)
        self.assertEqual(done.returncode, 1)
        self.assertIn("another program is adding", done.stderr)
        self.assertFalse(os.path.exists(history))
        fcntl.flock(folder, fcntl.LOCK_UN)
        self.assertIn("1 scans since", self.succeeds("drift", scan, "--history", history))

    def test_a_sensor_that_drifts_is_told_in_text_json_and_picture(self):
        clean = [self.scan(f"clean{n}", vase(n), n) for n in range(10)]
        history = self.path("ring.json")
        said = self.succeeds("drift", *clean, "--history", history)
        self.assertIn("10 scans since the calibration, no drift", said)
        drifted = [self.scan(f"drift{n}", vase(50 + n, 0.5), 50 + n) for n in range(6)]
        picture = self.path("drift.png")
        report = json.loads(self.succeeds("drift", *drifted, "--history", history, "--plot", picture, "--json", "-"))
        self.assertEqual((report["scans_added"], report["scans"], report["baseline_ready"]), (6, 16, True))
        self.assertEqual([alarm["sensor"] for alarm in report["alarms"]], [SENSOR])
        self.assertAlmostEqual(report["alarms"][0]["drift_mm"], 0.5, delta=0.2)
        self.assertEqual(report["exchanged"], [])
        with open(picture, "rb") as file:
            self.assertEqual(file.read(4), b"\x89PNG")
        # The same scans again count nothing, and the history alone says the same.
        again = json.loads(self.succeeds("drift", *drifted, "--history", history, "--json", "-"))
        self.assertEqual((again["scans_added"], again["scans_known"], again["scans"]), (0, 6, 16))
        self.assertIn("ALARM: sensor 47", self.succeeds("drift", "--history", history))

    def test_exchanged_channels_are_named_and_kept_out_of_the_history(self):
        shape = vase(3)
        places = {30: 33, 33: 30}
        scan = self.scan("swapped", lambda theta, z, sensor: shape(math.radians(2 * places.get(sensor, sensor)), z, sensor), 3)
        report = json.loads(self.succeeds("drift", scan, "--history", self.path("h.json"), "--json", "-"))
        self.assertEqual([(swap["sensor_a"], swap["sensor_b"]) for swap in report["exchanged"]], [(30, 33)])
        self.assertEqual(report["scans"], 0)

    def test_a_damaged_history_is_refused_and_stays(self):
        scan = self.scan("a", vase(1), 1)
        with open(self.path("h.json"), "w", encoding="utf-8") as file:
            file.write('{"format": "annulus drift history", "version": 1')
        done = self.run_program("drift", scan, "--history", self.path("h.json"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("read the drift history", done.stderr)
        with open(self.path("h.json"), encoding="utf-8") as file:
            self.assertTrue(file.read().endswith("1"))

    def test_the_daily_check_passes_a_good_ring_and_fails_a_bad_one(self):
        target = "cylinder:radius_mm=150,u_mm=0.02,serial=C-17"
        good = self.scan("good", column(150.0), 5)
        said = self.succeeds("check", "--scan", good, "--target", target, "--history", self.path("h.json"), "--json",
                             self.path("check.json"))
        self.assertTrue(said.startswith("PASS"), said)
        with open(self.path("check.json"), encoding="utf-8") as file:
            record = json.load(file)
        self.assertEqual((record["verdict"], record["target_serial"], record["findings"]), ("pass", "C-17", []))
        self.assertAlmostEqual(record["x_mm"], 40.0, delta=0.1)
        self.assertAlmostEqual(record["y_mm"], -60.0, delta=0.1)
        bad = self.scan("bad", column(150.0, longer_mm=0.4), 6)
        done = self.run_program("check", "--scan", bad, "--target", target, "--json", "-")
        self.assertEqual(done.returncode, 1)
        record = json.loads(done.stdout)
        self.assertEqual(record["verdict"], "fail")
        self.assertAlmostEqual(record["common_mm"], 0.4, delta=0.05)
        self.assertIn("47 (+0.", " ".join(record["findings"]))
        self.assertEqual(self.run_program("check", "--scan", good, "--target", "cylinder:radius_mm=x").returncode, 2)
        self.assertEqual(self.run_program("check", "--scan", good, "--target", "cylinder:radius_mm=75,u_mm=0").returncode, 1)


if __name__ == "__main__":
    annulus_cli.main()
