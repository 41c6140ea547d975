#!/usr/bin/python3
"""region: what two planes cut from a circular cylinder, whose wedges have closed forms."""

import math

import annulus_cli
from annulus_cli import EllipticCylinder, ProgramTest

RADIUS = 120.0
CYLINDER = EllipticCylinder(a=RADIUS, b=RADIUS, x0=0.0, y0=0.0)
ALPHA = math.radians(50)  # the chord AB is at 90 ± 50 degrees, z = 200
SLOPE = 0.5  # of either plane, up and down
SKIN = 4 * SLOPE * RADIUS**2 * (math.sin(ALPHA) - ALPHA * math.cos(ALPHA))
VOLUME = 2 * SLOPE * RADIUS**3 * (
    2 / 3 * math.sin(ALPHA)**3 - math.cos(ALPHA) * (ALPHA - math.sin(ALPHA) * math.cos(ALPHA)))


def on_plane(theta_deg, slope):
    """A place of the cylinder on the plane that contains AB and rises towards the front by `slope`."""
    return f"{theta_deg},{200 + slope * RADIUS * (math.sin(math.radians(theta_deg)) - math.cos(ALPHA)):.9f}"


A, B, C, D = on_plane(40, 0), on_plane(140, 0), on_plane(95, SLOPE), on_plane(80, -SLOPE)


class Region(ProgramTest):
    def setUp(self):
        super().setUp()
        self.import_cylinder(CYLINDER)
        self.succeeds("fit", "scan.mcap", "--out", "model.json")

    def region(self, *options, a=A, b=B, c=C, d=D):
        return ("region", "model.json", "--a", a, "--b", b, "--c", c, "--d", d, *options)

    def test_a_wedge_has_its_area_and_volume_and_their_sigmas(self):
        report = self.succeeds_json(*self.region())
        self.assertEqual(report["method"], "spline")
        self.assertAlmostEqual(report["area_mm2"], SKIN, delta=0.01 * SKIN)
        self.assertAlmostEqual(report["volume_mm3"], VOLUME, delta=0.02 * VOLUME)
        self.assertLess(abs(report["area_mm2"] - SKIN), 5 * report["area_sigma_mm2"] + 0.002 * SKIN)
        self.assertLess(abs(report["volume_mm3"] - VOLUME), 5 * report["volume_sigma_mm3"] + 0.002 * VOLUME)
        self.assertGreater(report["measured_share"], 0.95)
        for name in ("cut_abc", "cut_abd"):
            self.assertGreater(len(report[name]), 10)
        for x, y, z in report["cut_abc"][1:-1]:
            self.assertAlmostEqual(z, 200 + SLOPE * (y - RADIUS * math.cos(ALPHA)), delta=2)

    def test_the_paper_s_method_is_near_and_the_difference_is_told(self):
        spline = self.succeeds_json(*self.region())
        paper = self.succeeds_json(*self.region("--method", "paper"))
        self.assertEqual(paper["method"], "paper")
        self.assertEqual(spline["paper"]["area_mm2"], paper["area_mm2"])
        self.assertAlmostEqual(paper["area_mm2"], spline["area_mm2"], delta=0.02 * SKIN)
        self.assertAlmostEqual(paper["volume_mm3"], spline["volume_mm3"], delta=0.02 * VOLUME)
        self.assertAlmostEqual(spline["paper"]["area_difference_mm2"], paper["area_mm2"] - spline["area_mm2"], places=6)
        self.assertIn("paper 001", self.succeeds(*self.region()))

    def test_the_order_of_clicks_does_not_matter(self):
        first = self.succeeds_json(*self.region())
        for clicks in ({"a": B, "b": A}, {"c": D, "d": C}):
            other = self.succeeds_json(*self.region(**clicks))
            self.assertAlmostEqual(other["area_mm2"], first["area_mm2"], delta=1e-6 * SKIN)
            self.assertAlmostEqual(other["volume_mm3"], first["volume_mm3"], delta=1e-6 * VOLUME)

    def test_points_that_enclose_nothing_are_named(self):
        self.fails(*self.region(b=A), naming=("A and B are the same point",))
        self.fails(*self.region(d=C), naming=("A, B, C and D lie in one plane",))
        self.fails(*self.region(c="95,500"), naming=("C", "400"))
        self.fails(*self.region(d="270,200"), naming=("around the body",))
        self.fails(*self.region(a="nan,200"), naming=("A", "finite"))

    def test_a_place_that_is_not_two_numbers_is_wrong_usage(self):
        for place in ("40", "40,x", "1,2,3"):
            self.fails(*self.region(a=place), status=2)


if __name__ == "__main__":
    annulus_cli.main()
