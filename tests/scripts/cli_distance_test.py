#!/usr/bin/python3
"""distance: by plane, by view, geodesic and tape, on an elliptic cylinder that unrolls to a sheet."""

import math

import annulus_cli
from annulus_cli import EllipticCylinder, ProgramTest

CYLINDER = EllipticCylinder()
KEYS = {"length_mm", "method", "sigma_mm", "measured_share", "path"}


def wall(theta_deg):
    theta = math.radians(theta_deg)
    r = CYLINDER.radius(theta)
    return r * math.cos(theta), r * math.sin(theta)


def arc(from_deg, to_deg, steps=20000):
    """Length of the wall between two directions, by a fine polygon."""
    points = [wall(from_deg + (to_deg - from_deg) * k / steps) for k in range(steps + 1)]
    return sum(math.dist(a, b) for a, b in zip(points, points[1:]))


class Distance(ProgramTest):
    def setUp(self):
        super().setUp()
        self.import_cylinder(CYLINDER)
        self.succeeds("fit", "scan.mcap", "--out", "model.json")

    def distance(self, *options):
        report = self.succeeds_json("distance", "model.json", *options)
        self.assertLessEqual(KEYS, set(report))
        return report

    def test_geodesic_and_tape_are_straight_on_the_unrolled_wall(self):
        expected = math.hypot(arc(50, 150), 120)
        for method in ("geodesic", "tape"):
            with self.subTest(method):
                report = self.distance("--from", "50,120", "--to", "150,240", "--method", method)
                self.assertEqual(report["method"], method)
                self.assertAlmostEqual(report["length_mm"], expected, delta=0.6)
                self.assertTrue(0.0 < report["sigma_mm"] < 1.0, report["sigma_mm"])
                self.assertGreater(report["measured_share"], 0.9)
                for end, (theta_deg, z) in ((0, (50, 120)), (-1, (150, 240))):
                    self.assertLess(math.dist(report["path"][end], (*wall(theta_deg), z)), 1.0)
                polygon = sum(math.dist(a, b) for a, b in zip(report["path"], report["path"][1:]))
                self.assertAlmostEqual(polygon, report["length_mm"], delta=0.01)

    def test_the_tape_is_not_longer_than_the_geodesic_and_both_are_the_same_backwards(self):
        there = ("--from", "-10,120", "--to", "70.5,140")
        back = ("--from", "70.5,140", "--to", "-10,120")
        lengths = {}
        for method in ("geodesic", "tape"):
            lengths[method] = self.distance(*there, "--method", method)["length_mm"]
            self.assertEqual(self.distance(*back, "--method", method)["length_mm"], lengths[method])
        self.assertLessEqual(lengths["tape"], lengths["geodesic"] * 1.0001)

    def test_plane_and_view_cut_along_the_level_of_three_points(self):
        expected = arc(60, 120)
        for extra in ((), ("--paper",)):
            plane = self.distance("--from", "60,200", "--via", "90,200", "--to", "120,200", "--method", "plane", *extra)
            self.assertAlmostEqual(plane["length_mm"], expected, delta=0.6)
            view = self.distance("--from", "60,200", "--to", "120,200", "--method", "view", "--view", "90,0", *extra)
            self.assertAlmostEqual(view["length_mm"], expected, delta=0.6)

    def test_the_terminal_shows_length_and_uncertainty(self):
        text = self.succeeds("distance", "model.json", "--from", "60,200", "--to", "120,200", "--method", "tape")
        self.assertRegex(text, r"tape distance [0-9.]+ mm ± [0-9.]+ \(95 %\), [0-9.]+ % measured")
        self.succeeds("distance", "model.json", "--from", "60,200", "--to", "120,200", "--method", "tape", "--json", "d.json")
        self.assertEqual(self.read_json("d.json")["method"], "tape")

    def test_options_that_do_not_fit_are_wrong_usage(self):
        places = ("--from", "60,200", "--to", "120,200")
        for arguments, name in (((*places, "--method", "plane"), "--via"), ((*places, "--method", "view"), "--view"),
                                ((*places, "--via", "90,200", "--method", "tape"), "--via"),
                                ((*places, "--view", "90,0", "--method", "geodesic"), "--view"),
                                ((*places, "--method", "tape", "--paper"), "--paper"),
                                (("--from", "60", "--to", "120,200", "--method", "tape"), "--from"),
                                (("--from", "60,200", "--to", "120,nan", "--method", "tape"), "--to"),
                                ((*places, "--method", "view", "--view", "90,95"), "--view"),
                                ((*places, "--method", "crow"), "--method"), (places, "--method")):
            with self.subTest(arguments):
                self.fails("distance", "model.json", *arguments, status=2, naming=(name,))

    def test_places_outside_the_scan_are_errors_that_name_the_range(self):
        for method in ("geodesic", "tape"):
            self.fails("distance", "model.json", "--from", "60,200", "--to", "120,2000", "--method", method, "--json",
                       "d.json", naming=("2000", "from 0 to 400"))


if __name__ == "__main__":
    annulus_cli.main()
