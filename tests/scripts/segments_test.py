#!/usr/bin/python3
"""Where the shared scans are not one star-shaped loop, against the known truth, and what the program then says.

usage: segments_test.py PATH/TO/annulus        prints "no data" and succeeds where the scans are absent
"""

import os
import sys

import numpy as np

import annulus_cli
import ring_data
from annulus_cli import ProgramTest

PARTING_KINDS = ("several loops", "axis outside", "in front")
SEEN_SHARE = 0.02  # A ring that sees more than the loop around its axis sees an area that differs by more than this.
RECALL = 0.95
PRECISION = 0.95


def parts_in_truth(section):
    """Whether a level shows more than one loop around the axis to a ring; loops inside the body (mouth) do not count."""
    differs = abs(section["visible_area_mm2"] / section["area_mm2"] - 1) > SEEN_SHARE
    return not section["axis_inside"] or (section["n_loops"] > 1 and differs)


class Segments(ProgramTest):
    data = ""

    def fit(self, name):
        noisy, clean, truth = ring_data.load(self.data, name)
        self.succeeds("import", noisy, "--out", "scan.mcap", "--force")
        self.succeeds("fit", "scan.mcap", "--out", "model.json", "--no-covariance", "--report", "report.json", timeout=300)
        return clean, truth, self.read_json("report.json")

    def check_levels(self, name, clean, truth, report):
        """Recall and precision per level of the truth that lies in the scan."""
        ranges = [(r["z_min_mm"], r["z_max_mm"]) for r in report["regions"] if r["kind"] in PARTING_KINDS]
        sections = [s for s in truth["sections"] if clean.z_mm.min() <= s["z_mm"] <= clean.z_mm.max()]
        is_true = np.array([parts_in_truth(s) for s in sections])
        found = np.array([any(low <= s["z_mm"] <= high for low, high in ranges) for s in sections])
        hits = int(np.sum(is_true & found))
        recall = hits / max(1, int(is_true.sum()))
        precision = hits / max(1, int(found.sum()))
        several = int(sum(s["n_loops"] > 1 for s in sections))
        print(f"\n{name}: of {len(sections)} levels {several} have several loops, {int(is_true.sum())} to be seen; "
              f"found {int(found.sum())}" +
              (f": recall {recall:.3f}, precision {precision:.3f}" if is_true.any() else ""))
        for region in report["regions"]:
            print(f"  {region['name']}, z {region['z_min_mm']:g} to {region['z_max_mm']:g}: {region['outcome']}")
        if is_true.any():
            self.assertGreaterEqual(recall, RECALL)
            self.assertGreaterEqual(precision, PRECISION)
        else:
            self.assertFalse(found.any())

    def check_unknown(self, report):
        """The main surface says unknown where it was given nothing."""
        for region in report["regions"]:
            if region["kind"] not in PARTING_KINDS[:2] or region["theta_to_deg"] - region["theta_from_deg"] < 360:
                continue
            with open(self.path("places.csv"), "w", encoding="utf-8") as f:
                f.write("theta_deg,z_mm\n")
                heights = np.arange(region["z_min_mm"], region["z_max_mm"], 20)
                f.writelines(f"{theta},{z}\n" for z in heights for theta in range(0, 360, 10))
            self.succeeds("eval", "model.json", "--points", "places.csv", "--out", "answers.csv")
            answers = self.read("answers.csv").decode().splitlines()[1:]
            self.assertTrue(all(line.endswith("unknown") for line in answers), region["name"])
            self.fails("section", "model.json", "--z", (region["z_min_mm"] + region["z_max_mm"]) / 2)

    def check_limbs(self, names):
        """The limbs are in the model, with an axis, and not known on the side that no sensor sees."""
        model = self.read_json("model.json")
        self.assertEqual(sorted(surface["name"] for surface in model["surfaces"]), sorted(("body", *names)))
        for surface, measured in list(zip(model["surfaces"], model["measured"]))[1:]:
            self.assertIn("axis", surface)
            cells = "".join(measured["rows"])
            self.assertTrue(0.3 < 1 - cells.count("u") / len(cells) < 0.8, surface["name"])

    def test_legs(self):
        clean, truth, report = self.fit("body_mean_female")
        self.check_levels("body_mean_female", clean, truth, report)
        self.check_unknown(report)
        self.check_limbs(("left leg", "right leg"))

    def test_legs_and_arms(self):
        clean, truth, report = self.fit("body_arms_mh_female")
        self.check_levels("body_arms_mh_female", clean, truth, report)
        self.check_unknown(report)
        self.check_limbs(("left leg", "right leg", "left arm", "right arm"))
        names = [region["name"] for region in report["regions"]]
        for hand in ("left hand", "right hand"):
            self.assertIn(hand, names)

    def test_a_torso_and_heads_are_one_loop(self):
        for name in ("torso_mean_female", "head_leeperrysmith", "head_ict_mix"):
            _, _, report = self.fit(name)
            parting = [region for region in report["regions"] if region["kind"] in PARTING_KINDS]
            print(f"\n{name}: {[region['name'] for region in report['regions']]}")
            self.assertEqual(parting, [])
            self.assertEqual([segment["name"] for segment in report["segments"]], ["body"])


if __name__ == "__main__":
    Segments.data = os.path.abspath(ring_data.data_or_leave())
    sys.stdout.reconfigure(line_buffering=True)
    annulus_cli.main()
