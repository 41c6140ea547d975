#!/usr/bin/python3
"""annulus elastic: an elliptic cylinder changed freely, by a load and by a band; report, maps, pictures, refusals."""

import csv
import io
import json
import math

import annulus_cli
from annulus_cli import EllipticCylinder, ProgramTest

CYLINDER = EllipticCylinder()
REGION = {"z_min_mm": 100, "z_max_mm": 300, "thickness_mm": 20, "spacing_mm": 14}
EDIT = {"theta_deg": 80, "z_mm": 200, "outward_mm": 8, "radius_mm": 60}
DENT = {"theta_deg": 80, "z_mm": 200, "outward_mm": -4, "radius_mm": 40}
GIRTHS = [60, 200]


class Elastic(ProgramTest):
    def setUp(self):
        super().setUp()
        self.import_cylinder(CYLINDER)
        self.succeeds("fit", "scan.mcap", "--out", "model.json")

    def ops(self, **script):
        self.write("ops.json", json.dumps({"girths_mm": GIRTHS, **script}))
        return "ops.json"

    def report(self, *arguments, model="model.json"):
        self.succeeds("elastic", model, "--ops", "ops.json", "--out", "out.json", "--json", "report.json", *arguments)
        return self.read_json("report.json")

    def radius(self, model, theta, z):
        self.write("points.csv", f"theta_deg,z_mm\n{theta},{z}\n")
        self.succeeds("eval", model, "--points", "points.csv", "--out", "at.csv")
        return float(next(csv.DictReader(io.StringIO(self.read("at.csv").decode())))["r_mm"])

    def test_a_free_edit_moves_the_surface_where_it_is_asked(self):
        before = self.read("model.json")
        self.ops(edits=[EDIT])
        report = self.report()
        self.assertEqual(self.read("model.json"), before)
        self.assertIsNone(report["elastic"])
        error = report["edits"][0]["largest_error_mm"]  # at checked places; a smooth body has few control points
        self.assertLess(error, 0.5)
        moved = [self.radius("out.json", *place) - self.radius("model.json", *place) for place in ((80, 200), (80, 110))]
        self.assertAlmostEqual(moved[0], 8, delta=1.25 * error)
        self.assertAlmostEqual(moved[1], 0, delta=error)
        # The bump's volume on a flat skin: h·∫(1 − (d/R)²)²·2πd·dd = πhR²/3; this skin is round.
        grown = report["volume_after_mm3"] - report["volume_before_mm3"]
        self.assertAlmostEqual(grown / (math.pi * 8 * 60 ** 2 / 3), 1, delta=0.1)
        far, near = report["girths"]
        self.assertAlmostEqual(far["tape_after_mm"], far["tape_before_mm"], delta=0.05)
        self.assertAlmostEqual(far["tape_before_mm"], CYLINDER.perimeter, delta=0.002 * CYLINDER.perimeter)
        self.assertGreater(near["tape_after_mm"], near["tape_before_mm"])

    def test_a_load_is_in_balance_and_its_maps_are_those_of_the_report(self):
        self.ops(region=REGION, loads=[DENT])
        words = ["outward", "sideways", "von-mises", "largest-strain", "smallest-strain", "area-strain", "pressure"]
        report = self.report(*[argument for word in words for argument in ("--map", f"{word}={word}.csv")])
        elastic = report["elastic"]
        self.assertEqual(elastic["termination"], "converged")
        self.assertLessEqual(elastic["residual"], 1e-8)
        self.assertEqual(elastic["region"]["measured_share"], 1.0)
        potential = elastic["potential_mj"]
        self.assertTrue(all(b <= a * (1 + 1e-12) for a, b in zip(potential, potential[1:])), potential)
        self.assertAlmostEqual(elastic["loads"][0]["outward_mean_mm"], -4, delta=0.05)
        self.assertLess(elastic["loads"][0]["force_n"], 0)
        keys = list(elastic["ranges"])
        for word, key in zip(words, keys):
            values = [float(row["value"]) for row in csv.DictReader(io.StringIO(self.read(f"{word}.csv").decode()))]
            self.assertEqual(len(values), elastic["region"]["columns"] * elastic["region"]["rows"])
            for found, told in zip((min(values), max(values)), elastic["ranges"][key]):
                self.assertAlmostEqual(found, told, delta=1e-6 * (1 + abs(told)))
        # The layer is nearly incompressible: what is pushed in comes out beside it.
        self.assertGreater(elastic["ranges"]["outward_mm"][1], 0.1)
        self.assertLess(abs(report["volume_after_mm3"] - report["volume_before_mm3"]), math.pi * 4 * 40 ** 2 / 3)
        self.succeeds("render", "out.json", "--map", "values", "--values", "von-mises.csv", "--view", "front", "--size",
                      "160", "--out", "map.png")

    def test_a_band_brings_the_girth_that_is_asked_for(self):
        tight = 0.98 * CYLINDER.perimeter
        self.ops(region=REGION, bands=[{"z_mm": 200, "width_mm": 30, "girth_mm": tight}])
        report = self.report()
        band = report["elastic"]["bands"][0]
        error = 2 * math.pi * report["surface"]["largest_error_mm"]
        self.assertAlmostEqual(band["girth_after_mm"], tight, delta=error)
        self.assertAlmostEqual(report["girths"][1]["tape_after_mm"], tight, delta=error)
        self.assertGreater(band["tension_n"], 0)
        # A taut band of tension T presses with T/r on every length: ∫ p dA = 2πT.
        pressed = 1e-3 * band["pressure_mean_kpa"] * band["contact_area_mm2"]
        self.assertAlmostEqual(pressed / (2 * math.pi * band["tension_n"]), 1, delta=0.05)

    def test_a_tilted_band_is_measured_in_its_plane(self):
        # Tilted about the x axis: an ellipse of a and b/cos; its centre does not matter.
        tilt = math.radians(20)
        longer = EllipticCylinder(b=CYLINDER.b / math.cos(tilt)).perimeter
        self.ops(region=REGION, bands=[{"z_mm": 200, "normal": [0, math.sin(tilt), math.cos(tilt)],
                                        "girth_mm": 0.985 * longer}])
        report = self.report()
        band = report["elastic"]["bands"][0]
        self.assertAlmostEqual(band["girth_before_mm"], longer, delta=0.002 * longer)
        self.assertEqual(report["elastic"]["termination"], "converged")
        error = 2 * math.pi * report["surface"]["largest_error_mm"] / math.cos(tilt)
        self.assertAlmostEqual(band["girth_after_mm"], 0.985 * longer, delta=error)

    def test_a_loose_band_changes_nothing(self):
        self.ops(region=REGION, bands=[{"z_mm": 200, "rest_length_mm": 2000, "stiffness_n": 60}])
        report = self.report()
        self.assertEqual(report["elastic"]["bands"][0]["tension_n"], 0)
        self.assertAlmostEqual(report["volume_change"], 0, delta=1e-12)

    def test_it_replays_to_the_byte(self):
        self.ops(region=REGION, edits=[EDIT], loads=[DENT])
        results = []
        for _ in range(2):
            self.report("--map", "von-mises=map.csv", "--picture", "change.png", "--picture", "von-mises=stress.png")
            names = ("out.json", "report.json", "map.csv", "change.png", "stress.png")
            results.append([self.read(name) for name in names])
        self.assertEqual(results[0], results[1])
        self.assertTrue(all(picture.startswith(b"\x89PNG") for picture in results[0][3:]))
        self.assertNotEqual(results[0][3], results[0][4])

    def test_a_model_of_the_papers_method_becomes_a_tensor_surface(self):
        self.succeeds("fit", "scan.mcap", "--method", "paper", "--out", "paper.json")
        self.ops(edits=[EDIT])
        self.report("--picture", "change.png", model="paper.json")
        self.assertAlmostEqual(self.radius("out.json", 80, 200) - self.radius("paper.json", 80, 200), 8, delta=0.5)
        self.assertIn("elastic", self.read_json("out.json")["provenance"]["method"])

    def refused(self, *arguments, naming, status=1):
        self.fails("elastic", "model.json", "--ops", "ops.json", "--out", "out.json", *arguments, naming=naming,
                   status=status)

    def test_what_cannot_be_is_told_and_leaves_no_file(self):
        self.ops(edits=[{**EDIT, "outwrd_mm": 3}])
        self.refused(naming=("edits[0].outwrd_mm",))
        self.ops(edits=[{**EDIT, "z_mm": 4000}])
        self.refused(naming=("4000",))
        self.ops(loads=[DENT])
        self.refused(naming=("'region'",))
        self.ops(region={**REGION, "thickness_mm": 500}, loads=[DENT])
        self.refused(naming=("thickness_mm",))
        self.ops(region={**REGION, "spacing_mm": 20}, bands=[{"z_mm": 200, "girth_mm": 600}])
        self.refused(naming=("smaller",))
        self.ops(region=REGION, bands=[{"z_mm": 320, "girth_mm": 780}])
        self.refused(naming=("320",))
        self.ops(segment="arm", edits=[EDIT])
        self.refused(naming=("'arm'", "body"))
        self.fails("elastic", "gone.json", "--ops", "ops.json", "--out", "out.json", naming=("gone.json",))

    def test_a_wrong_map_or_view_leaves_no_file_either(self):
        self.ops(region=REGION, loads=[DENT])
        self.refused("--map", "outward=a.csv", "--map", "colour=b.csv", naming=("colour", "von-mises"), status=2)
        self.refused("--map", "outward", naming=("WORD=FILE",), status=2)
        self.refused("--picture", "a.png", "--view", "upstairs", naming=("upstairs",), status=2)
        self.ops(edits=[EDIT])
        self.refused("--map", "outward=a.csv", naming=("neither loads nor bands",))
        self.refused("--picture", "a.png", "--picture", "pressure=b.png", naming=("neither loads nor bands",))


if __name__ == "__main__":
    annulus_cli.main()
