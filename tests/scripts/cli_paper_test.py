#!/usr/bin/python3
"""`fit --method paper` and what reads its model, on an elliptic cylinder. The surface of MODEL.json is evaluated here once
more, from the definition of uniform cubic B-splines."""

import csv
import json
import math
import struct

import annulus_cli
from annulus_cli import EllipticCylinder, ProgramTest

CYLINDER = EllipticCylinder()


def uniform_weights(t):
    s = 1 - t
    return [s**3 / 6, (4 - 6 * t * t + 3 * t**3) / 6, (4 - 6 * s * s + 3 * s**3) / 6, t**3 / 6]


class Surface:
    """P(u, v) = sum of N_i(u) N_j(v) Q_ij: closed in u, open in v."""

    def __init__(self, paper):
        self.theta = paper["around"]["knots_rad"]
        self.z = paper["along"]["knots_mm"]
        self.q = paper["control_points_mm"]

    def at(self, u, v):
        m = len(self.theta)
        i, j = int(u) % m, min(int(v), len(self.z) - 2)
        along, up = uniform_weights(u - math.floor(u)), uniform_weights(v - j)
        point = [0.0, 0.0, 0.0]
        for b in range(4):
            for a in range(4):
                q = self.q[(j + b) * m + (i + a - 1) % m]
                for k in range(3):
                    point[k] += along[a] * up[b] * q[k]
        return point

    def solve(self, theta, z):
        """(u, v) by bisection."""
        low, high = 0.0, len(self.z) - 1.0
        for _ in range(100):
            v = 0.5 * (low + high)
            low, high = (v, high) if self.at(0, v)[2] < z else (low, v)
        low, high = 0.0, float(len(self.theta))
        for _ in range(100):
            u = 0.5 * (low + high)
            x, y, _ = self.at(u, v)
            turned = (math.atan2(y, x) - self.theta[0]) % (2 * math.pi)
            low, high = (u, high) if turned < (theta - self.theta[0]) % (2 * math.pi) else (low, u)
        return u, v


class Paper(ProgramTest):
    def setUp(self):
        super().setUp()
        self.import_cylinder(CYLINDER)
        self.succeeds("fit", "scan.mcap", "--out", "model.json", "--method", "paper", "--report", "report.json",
                      "--report-image", "paper.png")
        self.paper = self.read_json("model.json")["surfaces"][0]["paper"]

    def evaluate(self, places):
        self.write("asked.csv", "theta_deg,z_mm\n" + "".join(f"{math.degrees(t)!r},{z!r}\n" for t, z in places))
        self.succeeds("eval", "model.json", "--points", "asked.csv", "--out", "answer.csv")
        return list(csv.DictReader(self.read("answer.csv").decode().splitlines()))

    def test_there_are_three_knots_per_feature(self):
        around, along = self.paper["around"], self.paper["along"]
        self.assertEqual(len(around["knots_rad"]), 3 * len(around["features"]))
        self.assertEqual(len(along["knots_mm"]), 3 * len(along["features"]) - 2)
        self.assertEqual(around["knots_rad"][::3], [f["theta_rad"] for f in around["features"]])
        self.assertEqual(along["knots_mm"][::3], [f["z_mm"] for f in along["features"]])
        self.assertEqual(len(self.paper["control_points_mm"]), len(around["knots_rad"]) * (len(along["knots_mm"]) + 2))

    def test_the_ellipse_s_extrema_are_features(self):
        # Of r(theta) as the ring sees it, by a fine search; noise of 0.3 mm moves the flat ones by a few samples.
        fine = [CYLINDER.radius(math.radians(k / 10)) for k in range(3600)]
        extrema = [k / 10 for k in range(3600)
                   if (fine[k] - fine[k - 1]) * (fine[(k + 1) % 3600] - fine[k]) <= 0]
        found = [math.degrees(f["theta_rad"]) for f in self.paper["around"]["features"] if f["kind"] == "extremum"]
        self.assertEqual(len(found), len(extrema))
        for place in extrema:
            self.assertLessEqual(min(abs((place - other + 180) % 360 - 180) for other in found), 6.0)

    def test_eval_is_the_surface_of_the_control_points(self):
        surface = Surface(self.paper)
        places = [(t, z) for t in surface.theta[::4] for z in surface.z[::3]]
        for (theta, z), row in zip(places, self.evaluate(places)):
            i, j = surface.theta.index(theta), surface.z.index(z)
            x, y, height = surface.at(i, j)
            self.assertAlmostEqual(height, z, delta=1e-9)
            self.assertAlmostEqual(float(row["r_mm"]), math.hypot(x, y), delta=1e-9)
        places = [(0.1 + 0.61 * k, 13.0 + 37.7 * (k % 10)) for k in range(40)]
        for (theta, z), row in zip(places, self.evaluate(places)):
            x, y, _ = surface.at(*surface.solve(theta, z))
            self.assertAlmostEqual(float(row["x_mm"]), x, delta=1e-8)
            self.assertAlmostEqual(float(row["y_mm"]), y, delta=1e-8)
            off = (math.atan2(float(row["y_mm"]), float(row["x_mm"])) - theta + math.pi) % (2 * math.pi) - math.pi
            self.assertLessEqual(abs(off), 1e-12)
            self.assertEqual(row["sigma_mm"], "")
            self.assertEqual(row["measured"], "measured")
            self.assertAlmostEqual(float(row["r_mm"]), CYLINDER.radius(theta), delta=1.0)

    def test_the_report_says_how_the_knots_were_found(self):
        report = self.read_json("report.json")
        self.assertEqual(report["method"], "paper")
        for name, unit in (("around", "rad3"), ("along", "mm3")):
            direction = report["paper"][name]
            self.assertGreater(direction["lambda_" + unit], 0)
            self.assertLessEqual(direction["cost_moved_mm2"], direction["cost_by_rule_mm2"])
            self.assertGreater(direction["gate_sd"], 3)
        self.assertLess(report["paper"]["tensor_error_mm"], 0.01)
        self.assertEqual(report["coefficients"], len(self.paper["control_points_mm"]))

    def test_the_picture_is_a_sheet_of_five_panels(self):
        data = self.read("paper.png")
        self.assertEqual(struct.unpack(">II", data[16:24]), (1920, 1190))
        self.assertGreater(len(data), 100_000)

    def test_other_commands_take_the_model(self):
        report = self.succeeds_json("section", "model.json", "--z", "200")
        self.assertAlmostEqual(report["perimeter_mm"], CYLINDER.perimeter, delta=1.0)
        self.assertIsNone(report["perimeter_sigma_mm"])
        kind = self.succeeds_json("inspect", "model.json")
        self.assertEqual(kind["surfaces"][0]["theta_knots"], len(self.paper["around"]["knots_rad"]))
        self.succeeds("render", "model.json", "--view", "front", "--size", "200", "--out", "p.png")

    def test_the_same_scan_gives_the_same_bytes(self):
        self.succeeds("fit", "scan.mcap", "--out", "again.json", "--method", "paper")
        self.assertEqual(self.read("again.json"), self.read("model.json"))

    def test_a_scan_of_a_few_levels_is_refused(self):
        self.write("few.csv", EllipticCylinder(height=80).csv())
        self.succeeds("import", "few.csv", "--out", "few.mcap")
        self.fails("fit", "few.mcap", "--out", "few.json", "--method", "paper", naming=("few.mcap", "levels", "adaptive"))

    def test_a_model_whose_surface_folds_is_refused(self):
        model = self.read_json("model.json")
        model["surfaces"][0]["paper"]["control_points_mm"][500][:2] = [0, 0]
        self.write("folded.json", json.dumps(model))
        self.fails("inspect", "folded.json", naming=("folded.json", "turns back"))


if __name__ == "__main__":
    annulus_cli.main()
