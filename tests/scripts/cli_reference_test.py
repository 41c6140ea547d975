#!/usr/bin/python3
"""Reference sensors on the simulated booth: doctor, scan, inspect, replay, recover, and a board that is lost on the way."""

import json
import os

import annulus_cli
from annulus_cli import ProgramTest

BOOTH = """[profile.belt]
z_top_mm = 1100.0
z_bottom_mm = 800.0
pitch_mm = 10.0
speed_mm_s = 300.0

[sim]
reference = true
sway = 1.0
"""


class Reference(ProgramTest):
    def scan(self, toml=BOOTH, name="scan.mcap"):
        self.write("booth.toml", toml)
        return self.succeeds_json("scan", "--config", "booth.toml", "--profile", "belt", "--out", name)

    def test_their_readings_are_recorded_and_replay_alike(self):
        done = self.scan()
        self.assertEqual(done["reference"], {"levels": done["levels"], "trouble": ""})
        self.assertEqual(done["missing_levels"], 0)
        seen = self.succeeds_json("inspect", "scan.mcap")["reference"]
        self.assertEqual(seen["board"], 1013)
        self.assertEqual(seen["firmware_version"], "1.2.0")
        self.assertEqual([(s["channel"], s["theta_deg"], s["height_mm"]) for s in seen["sensors"]],
                         [(0, 90.0, 950.0), (1, 0.0, 950.0), (2, 90.0, 1500.0), (3, 0.0, 1500.0)])
        self.assertEqual(seen["levels"], done["levels"])
        # Of four sensors each, less what the ring hides when it passes 950 mm, and a lost return now and then.
        self.assertGreater(seen["returns"], 3 * done["levels"])
        self.assertLess(seen["returns"], 4 * done["levels"])
        self.assertTrue(self.succeeds_json("replay", "scan.mcap")["identical"])
        self.succeeds("replay", "scan.mcap", "--out", "again.mcap")
        self.assertEqual(self.succeeds_json("inspect", "again.mcap")["hash"],
                         self.succeeds_json("inspect", "scan.mcap")["hash"])
        self.succeeds("recover", "scan.mcap", "--out", "recovered.mcap")
        self.assertEqual(self.succeeds_json("inspect", "recovered.mcap")["reference"], seen)
        self.succeeds("export", "scan.mcap", "--out", "scan.csv")

    def test_the_fit_takes_the_sway_from_them_too(self):
        twice = BOOTH.replace("speed_mm_s = 300.0\n", "speed_mm_s = 300.0\nsweeps = 2\n")
        self.scan(twice.replace("reference = true\n", ""))
        self.succeeds("fit", "scan.mcap", "--out", "model.json", "--report", "report.json")
        without = self.read_json("report.json")["sway"]
        self.assertEqual(without["reference_readings"], 0)
        os.remove(self.path("scan.mcap"))
        done = self.scan(twice)
        self.succeeds("fit", "scan.mcap", "--out", "model.json", "--report", "report.json")
        sway = self.read_json("report.json")["sway"]
        self.assertTrue(sway["seen"], sway["reason"])
        # Two of the four look at the heights that were scanned; the ring hides them for a part of the way.
        self.assertGreater(sway["reference_readings"], done["levels"] // 3)
        self.assertLess(sway["reference_readings"], 2 * done["levels"])

    def test_a_scan_without_them_says_nothing_of_them(self):
        done = self.scan(BOOTH.replace("reference = true\n", ""))
        self.assertIsNone(done["reference"])
        self.assertIsNone(self.succeeds_json("inspect", "scan.mcap")["reference"])

    def test_a_board_that_is_unplugged_on_the_way_ends_no_scan(self):
        fault = {"at": {"level": 10}, "target": "usb", "kind": "unplug", "args": {"board": 12}}
        self.write("plan.json", json.dumps({"format": "annulus fault plan", "version": 1, "seed": 3, "faults": [fault]}))
        done = self.scan(BOOTH + 'faults = "plan.json"\n')
        self.assertEqual(done["missing_levels"], 0)
        self.assertEqual(done["levels"], done["planned_levels"])
        self.assertIn("unplugged", done["reference"]["trouble"])
        self.assertLess(done["reference"]["levels"], 15)
        self.assertGreaterEqual(done["reference"]["levels"], 10)
        self.assertEqual(self.succeeds_json("inspect", "scan.mcap")["reference"]["levels"], done["reference"]["levels"])
        self.assertTrue(self.succeeds_json("replay", "scan.mcap")["identical"])
        self.assertIn("1013", self.succeeds("scan", "--config", "booth.toml", "--profile", "belt", "--out", "b.mcap"))

    def test_doctor_lists_the_board_and_misses_it(self):
        self.write("booth.toml", BOOTH)
        report = self.succeeds_json("doctor", "--config", "booth.toml")
        board = next(i for i in report["items"] if i["name"] == "reference board 1013")
        self.assertEqual(board["verdict"], "ok")
        self.assertIn("950 mm at 90 deg", board["seen"])
        sensors = "[ { channel = 0, theta_deg = 90, distance_mm = 900, height_mm = 950 } ]"
        self.write("booth.toml", f"[ring]\nreference = {{ board = 1013, sensors = {sensors} }}\n")
        done = self.run_program("doctor", "--config", "booth.toml", "--json", "report.json")
        self.assertEqual(done.returncode, 1, done.stderr)
        board = next(i for i in self.read_json("report.json")["items"] if i["name"] == "reference board 1013")
        self.assertEqual(board["verdict"], "problem")
        self.assertIn("not there", board["seen"])

    def test_a_board_that_is_not_there_is_done_without(self):
        sensors = "[ { channel = 0, theta_deg = 90, distance_mm = 900, height_mm = 950 } ]"
        toml = BOOTH.replace("reference = true\n", "") + f"[ring]\nreference = {{ board = 1013, sensors = {sensors} }}\n"
        done = self.scan(toml)
        self.assertEqual(done["missing_levels"], 0)
        self.assertEqual(done["reference"]["levels"], 0)
        self.assertIn("not there", done["reference"]["trouble"])
        self.assertEqual(self.succeeds_json("inspect", "scan.mcap")["reference"]["levels"], 0)
        self.assertTrue(self.succeeds_json("replay", "scan.mcap")["identical"])


if __name__ == "__main__":
    annulus_cli.main()
