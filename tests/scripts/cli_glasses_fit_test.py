#!/usr/bin/python3
"""glasses fit and rank on a scanned head of the simulated booth: what the files say, what follows what, every refusal."""

import csv
import json

import annulus_cli
from annulus_cli import ProgramTest

RX = {"format": "annulus-rx", "version": 1, "date": "2026-05-04", "prescriber": "Dr. Tanaka", "refracted_vertex_mm": 12,
      "right": {"sph_d": -6, "cyl_d": -0.75, "axis_deg": 90}, "left": {"sph_d": -5.5},
      "centration": {"status": "estimate"}}


class Fit(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.model = None

    def setUp(self):
        super().setUp()
        self.write("booth.toml", '[sim]\nsubject = "head"\nseed = 4\n')
        if Fit.model is None:
            self.succeeds("scan", "--config", "booth.toml", "--profile", "head", "--out", "head.mcap")
            self.succeeds("fit", "head.mcap", "--out", "head.json")
            Fit.model = self.read("head.json")
        self.write("head.json", Fit.model)
        self.succeeds("glasses", "design", "--style", "boston", "--size", "medium", "--out", "frame.json")

    def fit(self, *options, frame="frame.json"):
        return self.succeeds_json("glasses", "fit", "head.json", "--frame", frame, "--out", "worn.json", *options)

    def goals(self, *options):
        return {goal["id"]: goal for goal in self.fit(*options)["goals"]}

    def test_every_target_has_value_sigma_and_range_and_unmet_ones_a_reason(self):
        report = self.fit("--size-free")
        ids = {goal["id"] for goal in report["goals"]}
        self.assertTrue({"pd_right", "pupil_height_left", "vertex_distance_right", "pantoscopic_tilt", "face_form", "dbl",
                         "temple_length_left"} <= ids, ids)
        for goal in report["goals"]:
            self.assertEqual(goal["met"], goal["low"] <= goal["value"] <= goal["high"], goal)
        unknown = {goal["id"] for goal in report["goals"] if "sigma" not in goal}
        self.assertEqual(unknown, {"skin_clearance", "nose_balance"})
        unmet = sum(not goal["met"] for goal in report["goals"])
        self.assertGreaterEqual(len(report["advice"]), min(unmet, 1))
        parts = {contact["part"]: contact for contact in report["contacts"]}
        for pad in ("pad_right", "pad_left"):
            self.assertLessEqual(abs(parts[pad]["distance_mm"]), 0.3)
        self.assertLessEqual(report["penetration_mm"], 0.05)

    def test_what_an_optician_measured_counts(self):
        goals = self.goals("--pd", "33;32", "--heights", "21;20")
        self.assertAlmostEqual(goals["pd_right"]["value"] + goals["pd_left"]["value"], 65.0, delta=0.3)
        low, high = goals["pupil_height_right"]["low"], goals["pupil_height_right"]["high"]
        self.assertTrue(low < 21 < high)
        moved = self.fit("--set", "ear_right=75,-15,1600")
        self.assertIsNotNone(moved)

    def test_the_clearance_map_has_every_part(self):
        self.fit("--clearance", "clearance.csv")
        rows = list(csv.DictReader(self.read("clearance.csv").decode().splitlines()))
        self.assertGreater(len(rows), 200)
        parts = {row["part"] for row in rows}
        self.assertTrue(any("rim" in part for part in parts) and any("temple" in part for part in parts), parts)
        self.assertGreaterEqual(min(float(row["distance_mm"]) for row in rows), -0.05)

    def test_a_prescription_is_kept_for_the_export_and_weighs(self):
        self.write("rx.json", json.dumps(RX))
        bare = self.fit("--size-free")
        report = self.fit("--size-free", "--rx", "rx.json", "--lens-material", "1.6", "--base-curve", "3")
        self.assertGreater(report["balance"]["lenses_g"], 3.0)
        self.assertEqual(bare["balance"]["lenses_g"], 0.0)
        right = report["lenses"]["right"]
        self.assertAlmostEqual(right["base_d"], 3.0)
        self.assertFalse(report["lenses"]["centration"].get("confirmed", False))
        self.fails("glasses", "export", "worn.json", "--out", "lab.dcs", naming=("--confirmed-by",))
        self.succeeds("glasses", "export", "worn.json", "--out", "lab.dcs", "--confirmed-by", "A. Optician")
        trace = self.read("lab.dcs").decode()
        for record in ("SPH=-6.00;-5.50", "LNAM=1.60;1.60", "_CONFIRMED=A. Optician"):
            self.assertIn(record, trace)
        # What is said at the export counts more than what is kept.
        self.succeeds("glasses", "export", "worn.json", "--out", "lab.dcs", "--confirmed-by", "A. Optician",
                      "--lens-material", "1.74")
        self.assertIn("LNAM=1.74;1.74", self.read("lab.dcs").decode())
        cells = [t for row in right["thickness_map"]["thickness_mm"] for t in row if t is not None]
        self.assertAlmostEqual(min(cells), right["thinnest_mm"], delta=0.1)
        self.assertGreater(max(cells), 2 * min(cells))

    def test_a_kept_lens_choice_that_is_damaged_makes_no_lens(self):
        self.write("rx.json", json.dumps(RX))
        self.fit("--rx", "rx.json", "--base-curve", "3")
        worn = self.read_json("worn.json")
        for key, value in (("base_curve_d", "3"), ("base_curve_d", 99), ("base_curve", 3), ("material", 1.6)):
            changed = json.loads(json.dumps(worn))
            changed["sections"]["lens_choice"] = {key: value}
            self.write("changed.json", json.dumps(changed))
            self.fails("glasses", "export", "changed.json", "--out", "order.pdf", "--order-sheet", "sheet.pdf",
                       naming=("lens choice", key))

    def test_pupils_of_the_prescription_count_and_typed_ones_more(self):
        order = json.loads(json.dumps(RX))
        for eye, pd, height in (("right", 34, 21), ("left", 33, 20)):
            order[eye].update(pd_mm=pd, height_mm=height)
        self.write("rx.json", json.dumps(order))
        goals = self.goals("--rx", "rx.json")
        self.assertAlmostEqual(goals["pd_right"]["value"] + goals["pd_left"]["value"], 67.0, delta=0.3)
        self.assertTrue(goals["pupil_height_right"]["low"] < 21 < goals["pupil_height_right"]["high"])
        goals = self.goals("--rx", "rx.json", "--pd", "32;31")
        self.assertAlmostEqual(goals["pd_right"]["value"] + goals["pd_left"]["value"], 63.0, delta=0.3)

    def test_the_heads_level_can_be_given(self):
        level = self.goals("--head-tilt", "0")["pantoscopic_tilt"]["value"]
        up = self.goals("--head-tilt", "4")["pantoscopic_tilt"]["value"]
        self.assertNotAlmostEqual(level, up, delta=0.01)

    def test_the_papers_placement_is_still_there(self):
        report = self.fit("--placement", "paper")
        self.assertAlmostEqual(report["tilt_deg"], 15.0)

    def test_rank_sorts_the_library(self):
        ranked = self.succeeds_json("glasses", "rank", "head.json", "--top", "1000")["frames"]
        self.assertGreaterEqual(len(ranked), 90)
        order = [(not frame["wearable"], -frame["score"]) for frame in ranked]
        self.assertEqual(order, sorted(order))
        self.assertTrue(ranked[0]["wearable"])
        for frame in ranked:
            self.assertTrue(frame["wearable"] or frame["advice"], frame["style"])

    def test_refuses_what_it_cannot_use(self):
        fit = ("glasses", "fit", "head.json", "--frame", "frame.json", "--out", "worn.json")
        self.fails(*fit, "--set", "eye_middle=0,0,0", naming=("eye_middle",))
        self.fails(*fit, "--set", "eye_right=high", naming=("eye_right=high",))
        self.fails(*fit, "--pd", "thirty", naming=("thirty",))
        self.fails(*fit, "--pd", "300;30", naming=("300",))
        self.write("rx.json", json.dumps(RX))
        self.fails(*fit, "--rx", "rx.json", "--lens-material", "glassine", naming=("glassine",))
        self.fails(*fit, "--rx", "missing.json", naming=("missing.json",))
        self.assertNotIn("worn.json", self.listing())


if __name__ == "__main__":
    annulus_cli.main()
