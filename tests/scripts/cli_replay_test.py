#!/usr/bin/python3
"""replay: a scan of the simulated booth again from its raw bytes, whole, in part, with faults, and of what is no scan."""

import json
import os

import annulus_cli
from annulus_cli import EllipticCylinder, ProgramTest

BOOTH = """[profile.belt]
z_top_mm = 1100.0
z_bottom_mm = 1000.0
pitch_mm = 10.0
speed_mm_s = 300.0
"""


def plan(*faults):
    return json.dumps({"format": "annulus fault plan", "version": 1, "seed": 3, "faults": faults})


class Replay(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("booth.toml", BOOTH)
        self.succeeds("scan", "--config", "booth.toml", "--profile", "belt", "--out", "scan.mcap")

    def test_is_identical_and_says_so(self):
        report = self.succeeds_json("replay", "scan.mcap")
        self.assertTrue(report["identical"])
        self.assertTrue(report["whole"])
        self.assertEqual(report["identical_levels"], report["recorded_levels"])
        self.assertGreaterEqual(report["recorded_levels"], 10)
        self.assertGreater(report["axis_points"], 10)
        self.assertIsNone(report["first_difference"])
        self.assertIn("identical", self.succeeds("replay", "scan.mcap"))

    def test_gives_a_part_and_keeps_real_time_if_asked(self):
        part = self.succeeds_json("replay", "scan.mcap", "--from", "2", "--to", "5", "--speed", "2")
        self.assertTrue(part["identical"])
        self.assertFalse(part["whole"])
        self.assertEqual(part["replayed_levels"], 4)
        self.assertGreaterEqual(part["replay_s"], 0.5 * 0.9 * part["scan_s"])

    def test_writes_a_recording_that_replays_alike(self):
        self.succeeds("replay", "scan.mcap", "--out", "again.mcap")
        self.assertTrue(self.succeeds_json("replay", "again.mcap")["identical"])
        for name in ("scan", "again"):
            self.succeeds("export", name + ".mcap", "--out", name + ".csv")
        self.assertEqual(self.read("scan.csv"), self.read("again.csv"))
        self.fails("replay", "scan.mcap", "--out", "again.mcap", naming=("again.mcap", "--force"))

    def test_with_faults_tells_what_would_have_been(self):
        unplug = {"at": {"level": 4}, "target": "usb", "kind": "unplug", "args": {"board": 3}}
        slip = {"at": {"time_s": 1}, "target": "axis", "kind": "slip", "args": {"speed_mm_s": 0.5}}
        self.write("plan.json", plan(unplug, slip))
        reports = []
        for _ in range(2):
            done = self.run_program("replay", "scan.mcap", "--faults", "plan.json", "--json", "-")
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn("ring board 1004", done.stderr)
            self.assertIn("unplugged", done.stderr)
            report = json.loads(done.stdout)
            report.pop("replay_s")
            reports.append(report)
        self.assertEqual(reports[0], reports[1])
        self.assertEqual(len(reports[0]["faults_passed_over"]), 1)
        self.assertIn("slip", reports[0]["faults_passed_over"][0])
        self.assertLess(reports[0]["replayed_levels"], reports[0]["recorded_levels"])

    def test_refuses_what_has_no_raw_bytes_and_what_makes_no_sense(self):
        self.write("cylinder.csv", EllipticCylinder().csv())
        self.succeeds("import", "cylinder.csv", "--out", "imported.mcap")
        self.fails("replay", "imported.mcap", naming=("imported.mcap", "no raw bytes"))
        self.fails("replay", "cylinder.csv", naming=("cylinder.csv",))
        self.fails("replay", "scan.mcap", "--from", "100000", naming=("100000", "it has only"))
        self.fails("replay", "scan.mcap", "--from", "5", "--to", "2", naming=("--to", "5"), status=2)
        self.fails("replay", "scan.mcap", "--out", "scan.mcap", "--force", naming=("the recording itself",))
        self.fails("replay", "scan.mcap", "--speed", "fast", naming=("fast", "max"), status=2)
        self.fails("replay", "scan.mcap", "--step", naming=("no terminal",), status=2)
        self.write("plan.json", "{}")
        self.fails("replay", "scan.mcap", "--faults", "plan.json", naming=("plan.json",))

    def test_of_a_cut_recording_goes_as_far_as_that(self):
        whole = open(os.path.join(self.folder, "scan.mcap"), "rb").read()
        with open(os.path.join(self.folder, "cut.mcap"), "wb") as f:
            f.write(whole[: len(whole) * 17 // 20])
        report = json.loads(self.run_program("replay", "cut.mcap", "--json", "-").stdout)
        self.assertTrue(report["identical"], report["first_difference"])
        self.assertGreater(report["identical_levels"], 0)


if __name__ == "__main__":
    annulus_cli.main()
