#!/usr/bin/python3
"""landmarks on a body like a vase, whose levels are known: found, set by hand, written, refused."""

import json
import math
import random

import annulus_cli
from annulus_cli import CSV_COLUMNS, RING_RADIUS_MM, ProgramTest

# Extrema of size(z), found as in tests/modeling_table/table_test.cpp with scipy.optimize.minimize_scalar.
LEVELS = {"level.head": 1589.58, "level.neck": 1468.43, "level.waist": 1093.01, "level.hip": 870.03}


def size(z):
    def bump(height, middle, width):
        return height * math.exp(-((z - middle) / width) ** 2)

    return 55 + bump(36, 1590, 85) + bump(85, 1265, 125) + bump(95, 870, 180)


def vase_csv():
    rng = random.Random(3)
    lines = [f"# vase; R_mm={RING_RADIUS_MM:g}", CSV_COLUMNS]
    for level in range(110):
        z = 1700 - 10 * level
        for sensor in range(180):
            radius = size(z) * (1 + 0.1 * math.cos(math.radians(4 * sensor)))
            lines.append(f"{level},{z},{sensor},{2 * sensor},{RING_RADIUS_MM - radius + rng.gauss(0, 0.3):.4f}")
    return "\n".join(lines) + "\n"


class LandmarksOfAVase(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("vase.csv", vase_csv())
        self.succeeds("import", "vase.csv", "--out", "scan.mcap")
        self.succeeds("fit", "scan.mcap", "--out", "model.json")

    def test_everything(self):
        self.levels_are_found()
        self.a_level_set_by_hand_is_kept_in_the_file()
        self.what_cannot_be_set_is_refused()

    def levels_are_found(self):
        found = {entry["id"]: entry for entry in self.succeeds_json("landmarks", "model.json")["landmarks"]}
        for name, z in LEVELS.items():
            self.assertAlmostEqual(found[name]["z_mm"], z, delta=3.0, msg=name)
            self.assertEqual(found[name]["source"], "detected")
            self.assertGreater(found[name]["z_sigma_mm"], 0.0)
        text = self.succeeds("landmarks", "model.json")
        for word in ("level.waist", "Natural waist level", "detected", "not found: "):
            self.assertIn(word, text)

    def a_level_set_by_hand_is_kept_in_the_file(self):
        arguments = ("landmarks", "model.json", "--set", "level.waist=1080", "--set", "neck_front=90,1440")
        self.assertEqual(self.succeeds(*arguments, "--out", "marks.json"), "")
        first = self.read("marks.json")
        self.succeeds(*arguments, "--out", "marks.json")
        self.assertEqual(self.read("marks.json"), first, "the same bytes")
        document = json.loads(first)
        self.assertEqual([entry["id"] for entry in document["given"]], ["neck_front", "level.waist"])
        point, waist = document["given"]
        self.assertAlmostEqual(point["theta_rad"], math.pi / 2)
        self.assertEqual((point["z_mm"], waist["z_mm"], waist["placing_sigma_mm"]), (1440, 1080, 2))
        set_waist = next(entry for entry in document["landmarks"] if entry["id"] == "level.waist")
        self.assertEqual((set_waist["source"], set_waist["confidence"], set_waist["z_mm"]), ("given", 1, 1080))

    def what_cannot_be_set_is_refused(self):
        def refused(text, *naming, status=1):
            self.fails("landmarks", "model.json", "--set", text, "--out", "other.json", naming=naming, status=status)

        refused("level.waste=1080", "level.waste", "level.waist")
        refused("level.waist=5000", "1700")
        refused("level.waist=90,1080", "no theta")
        refused("neck_front=1440", "theta")
        for text in ("level.waist", "=3", "level.waist=", "level.waist=nan", "neck_front=1,2,3", "neck_front=a,2"):
            refused(text, text, status=2)
        self.fails("landmarks", "nothing.json", naming=("nothing.json",))


if __name__ == "__main__":
    annulus_cli.main()
