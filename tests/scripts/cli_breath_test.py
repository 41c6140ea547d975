#!/usr/bin/python3
"""scan with a parked ring, and breath: the girth over a breath of the simulated person."""

import annulus_cli
from annulus_cli import ProgramTest

KEYS = {"z_mm", "breathing", "breaths", "period_s", "min_mm", "mean_mm", "max_mm", "sigma_mm", "amplitude_mm", "curve"}


class Breath(ProgramTest):
    def scan(self, *arguments):
        return self.succeeds_json("scan", "--config", "booth.toml", "--profile", "breath", "--out", "b.mcap", *arguments)

    def test_a_scan_with_a_parked_ring_ends_with_the_girths_of_a_breath(self):
        self.write("booth.toml", "[sim]\nbreathing = 0.015\nsway = 1\n")
        report = self.scan("--breath-image", "b.png")["breath"]
        self.assertLessEqual(KEYS, set(report))
        self.assertTrue(report["breathing"])
        self.assertAlmostEqual(report["z_mm"], 1230, delta=10)
        self.assertAlmostEqual(report["period_s"], 4.0, delta=0.15)
        # 1.5 % of the girth at the chest's middle, 1249.5 mm; 18 mm below it 0.986 times that.
        self.assertAlmostEqual(report["amplitude_mm"] / report["min_mm"], 0.0148, delta=0.0008)
        self.assertTrue(report["min_mm"] < report["mean_mm"] < report["max_mm"])
        self.assertTrue(self.read("b.png").startswith(b"\x89PNG\r\n\x1a\n"))
        # Afterwards, from the recording, it is the same.
        self.assertEqual(self.succeeds_json("breath", "b.mcap"), report)
        self.assertIn("breathed out", self.succeeds("breath", "b.mcap", "--image", "again.png"))
        self.assertIn("again.png", self.listing())

    def test_somebody_who_holds_the_breath_is_told_so(self):
        self.write("booth.toml", "[sim]\nsway = 1\n")
        report = self.scan()["breath"]
        self.assertFalse(report["breathing"])
        self.assertIsNone(report["period_s"])
        self.assertIn("not significant", self.succeeds("breath", "b.mcap"))

    def test_a_height_at_which_the_arms_hide_the_chest_is_refused_with_advice_and_the_recording_kept(self):
        self.write("booth.toml", "[profile.breath]\nz_top_mm = 1300\n")
        report = self.scan()
        self.assertIsNone(report["breath"])
        self.assertIn("was not seen", report["breath_trouble"])
        self.fails("breath", "b.mcap", naming=("1300 mm", "armpits"))

    def test_a_scan_with_a_ring_that_moves_has_no_breath(self):
        self.write("booth.toml", "[profile.belt]\nz_top_mm = 1400\nz_bottom_mm = 1000\npitch_mm = 5\nspeed_mm_s = 100\n")
        report = self.succeeds_json("scan", "--config", "booth.toml", "--profile", "belt", "--out", "s.mcap")
        self.assertNotIn("breath", report)
        self.fails("breath", "s.mcap", naming=("the ring moved", "profile breath"))


if __name__ == "__main__":
    annulus_cli.main()
