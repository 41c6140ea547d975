#!/usr/bin/python3
"""annulus wrinkly: the shuffle, control meshes, pictures, fits, refusals."""

import json
import math
import struct
import unittest
import zlib

import annulus_cli
import numpy
from annulus_cli import ProgramTest
from png_image import read_png


def pattern(s, m, k):
    """DESIGN.md §5, step by step on an endless axis: the small intervals that block s shows after k iterations."""
    if k == 0:
        return [(s, ())]
    return [(interval, (*digits, p)) for p in range(2 * m + 1) for interval, digits in pattern(s + p - m, m, k - 1)]


def grey_png(grey):
    """An 8-bit grey PNG of an array of 0 … 255."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    height, width = grey.shape
    rows = b"".join(b"\0" + row.tobytes() for row in grey.astype(numpy.uint8))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


CUBE = """v 0 0 0\nv 80 0 0\nv 0 80 0\nv 80 80 0\nv 0 0 80\nv 80 0 80\nv 0 80 80\nv 80 80 80
f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"""


class Wrinkly(ProgramTest):
    def report(self, *arguments):
        self.succeeds("wrinkly", *arguments, "--json", "report.json")
        return self.read_json("report.json")

    def refused(self, *arguments, code=1):
        done = self.run_program("wrinkly", *arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertTrue(done.stderr.startswith("annulus: "), done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        return done.stderr

    def test_the_list_is_the_design_construction(self):
        for m, k, n in ((1, 2, 8), (2, 2, 5), (1, 3, 4), (3, 1, 3), (1, 0, 3), (0, 2, 3)):
            pairs = json.loads(self.succeeds("wrinkly", "ist", "--m", m, "--k", k, "--intervals", n, "--axis", "cyclic",
                                             "--json", "-"))
            self.assertEqual(len(pairs), n * (2 * m + 1) ** k)
            shown = {(pair["destination"]["interval"], tuple(pair["destination"]["digits"])): pair["source"]
                     for pair in pairs}
            for s in range(n):
                for place, (interval, digits) in enumerate(pattern(s, m, k)):
                    p = tuple(place // (2 * m + 1) ** (k - 1 - d) % (2 * m + 1) for d in range(k))
                    self.assertEqual(shown[s, p], {"interval": interval % n, "digits": list(digits)})

    def test_open_axes_are_one_to_one_and_say_what_is_mirrored(self):
        pairs = json.loads(self.succeeds("wrinkly", "ist", "--m", 2, "--k", 2, "--intervals", 3, "--axis", "open",
                                         "--json", "-"))
        places = {(pair["destination"]["interval"], *pair["destination"]["digits"]) for pair in pairs}
        self.assertEqual(len(places), 75)
        for pair in pairs:
            i, digits = pair["source"]["interval"], pair["source"]["digits"]
            free = i - sum(digit - 2 for digit in digits)
            self.assertEqual(pair.get("mirrored", False), free % 6 > 2)

    def test_meshes_are_described_and_read_back(self):
        report = self.report("mesh", "directions:3x4", "--heights", "0,20", "--out", "net.json")
        self.assertEqual(report["patches"], 6 * 16)
        self.assertEqual(report["u_axes"] + report["v_axes"], 6 * 4)
        self.assertEqual(report["cells_by_corners"]["6"], 1)
        again = self.report("mesh", "net.json", "--out", "again.json")
        self.assertEqual(again["axes"], report["axes"])
        self.assertEqual(self.read("again.json"), self.read("net.json"))

    def test_a_mesh_of_one_family_is_named_and_can_be_cut(self):
        self.write("cube.obj", CUBE)
        said = self.refused("mesh", "cube.obj", "--out", "cube.json")
        self.assertIn("along the loop of control points", said)
        self.assertNotIn("cube.json", self.listing())
        report = self.report("mesh", "cube.obj", "--cut")
        self.assertGreater(report["links_cut"], 0)
        paper, rounded = report["joins"], self.report("mesh", "cube.obj", "--cut", "--rounded")["joins"]
        self.assertGreater(paper["irregular_mean_rad"], 1e-2)
        self.assertLess(rounded["irregular_mean_rad"], 1e-3)

    def test_pictures_show_more_triangles_where_they_come_near(self):
        far = self.report("render", "figure13", "--size", "160,120", "--out", "far.png", "--view", "90,60", "--triangle", "1")
        near = self.report("render", "figure13", "--size", "160,120", "--out", "near.png", "--view", "90,60", "--triangle", "1",
                           "--zoom", "9", "--at", "0.5,0.5")
        self.assertGreaterEqual(near["deepest"], far["deepest"] + 2)
        # At most 9 cells per pixel, in some three layers: spikes reach into the picture from beside it.
        self.assertLess(near["cells"], 3 * 160 * 120 * 9)
        for name in ("far.png", "near.png"):
            pixels = read_png(self.read(name))
            self.assertEqual(pixels.shape[:2], (120, 160))
            self.assertGreater(pixels[40:80, 50:110].std(), 10.0)
        smooth = self.report("render", "figure13", "--size", "160,120", "--out", "smooth.png", "--view", "90,60", "--triangle", "1", "--k", "0")
        self.assertEqual(smooth["cells"], far["cells"])
        def roughness(name):  # from pixel to pixel, within the surface
            return numpy.abs(numpy.diff(read_png(self.read(name))[48:72, 65:95].astype(float), axis=1)).mean()
        self.assertGreater(roughness("far.png"), 3.0 * roughness("smooth.png"))

    def test_the_bear_is_drawn_by_both_renderers(self):
        for method in ("zbuffer", "trace"):
            report = self.report("render", "bear", "--size", "96,96", "--out", f"{method}.png", "--method", method,
                                 "--samples", "4", "--view", "70,10")
            self.assertGreater(report["triangles"], 10_000)
            pixels = read_png(self.read(f"{method}.png")).astype(float)
            red, blue = pixels[30:70, 38:58, 0].mean(), pixels[30:70, 38:58, 2].mean()
            self.assertGreater(red, 1.3 * blue, method)  # brown

    def test_even_triangles_are_written(self):
        self.succeeds("wrinkly", "render", "torus:8x6", "--triangles", "torus.obj", "--depth", "1")
        faces = [line for line in self.read("torus.obj").decode().splitlines() if line.startswith("f ")]
        self.assertEqual(len(faces), 48 * 9 * 4)

    def test_heights_of_a_picture_are_found(self):
        side = 96
        x, y = numpy.meshgrid((numpy.arange(side) + 0.5) / side, (numpy.arange(side) + 0.5) / side)
        smooth = 0.5 + 0.4 * numpy.sin(5.0 * x) * numpy.cos(4.0 * y)
        # The program reads sRGB: this is its inverse.
        srgb = numpy.where(smooth <= 0.0031308, 12.92 * smooth, 1.055 * smooth ** (1 / 2.4) - 0.055)
        self.write("heights.png", grey_png(numpy.rint(255 * srgb)))
        report = self.report("fit", "regular:14x14", "--image", "heights.png", "--high", "10", "--k", "0", "--out", "mesh.json")
        height = report["attributes"][0]
        self.assertEqual((height["name"], height["not_seen"]), ("height", 0))
        self.assertLess(height["rms"], 0.05)
        self.assertAlmostEqual(height["rms_before"], 10 * smooth.std(), delta=0.05)
        points = json.loads(self.read("mesh.json"))["points"]
        middle = points[7 * 14 + 7]["values"][0]
        coloured = self.report("fit", "mesh.json", "--image", "heights.png", "--as", "colour", "--k", "0", "--out", "colour.json")
        self.assertEqual([one["name"] for one in coloured["attributes"]], ["red", "green", "blue"])
        mesh = json.loads(self.read("colour.json"))
        self.assertEqual(mesh["attributes"], ["height", "red", "green", "blue"])
        for value, kept in zip(mesh["points"][105]["values"], (middle, *[middle / 10] * 3)):
            self.assertAlmostEqual(value, kept, delta=0.002)
        self.assertAlmostEqual(middle, 10 * (0.5 + 0.4 * math.sin(5 * 7.5 / 14) * math.cos(4 * (1 - 7.5 / 14))), delta=0.1)

    def test_the_list_of_three_crossings_and_six_iterations_is_one_to_one(self):
        pairs = json.loads(self.succeeds("wrinkly", "ist", "--m", 3, "--k", 6, "--intervals", 2, "--axis", "open", "--json", "-"))
        self.assertEqual(len({(pair["destination"]["interval"], *pair["destination"]["digits"]) for pair in pairs}), 2 * 7**6)

    def test_what_the_smooth_surface_leaves_of_a_scan_is_found(self):
        self.import_cylinder(annulus_cli.EllipticCylinder(), noise=0.02)
        self.succeeds("fit", "scan.mcap", "--out", "model.json")
        # The same cylinder with ribs of 1 mm that the model does not have.
        lines = self.read("cylinder.csv").decode().splitlines()
        columns = next(line for line in lines if not line.startswith("#")).split(",")
        at = {name: columns.index(name) for name in ("z_mm", "theta_deg", "range_mm")}
        for k, line in enumerate(lines):
            row = line.split(",")
            if line.startswith("#") or row == columns or row[at["range_mm"]] == "nan":
                continue
            z, theta = float(row[at["z_mm"]]), math.radians(float(row[at["theta_deg"]]))
            row[at["range_mm"]] = repr(float(row[at["range_mm"]]) - math.sin(6 * theta) * math.sin(z / 30))
            lines[k] = ",".join(row)
        self.write("ribs.csv", "\n".join(lines) + "\n")
        self.succeeds("import", "ribs.csv", "--out", "ribs.mcap")
        report = self.report("fit", "model.json", "--scan", "ribs.mcap", "--k", "0", "--columns", "48", "--rows", "24",
                             "--out", "texture.json")["attributes"][0]
        self.assertEqual((report["name"], report["not_seen"]), ("height", 0))
        self.assertGreater(report["targets"], 6000)
        self.assertAlmostEqual(report["rms_before"], 0.5, delta=0.05)  # of a product of sines
        self.assertLess(report["rms"], 0.1 * report["rms_before"])

    def test_models_and_frames_are_dressed(self):
        self.import_cylinder(annulus_cli.EllipticCylinder())
        self.succeeds("fit", "scan.mcap", "--out", "model.json")
        self.succeeds("glasses", "design", "--style", "boston", "--out", "frame.json")
        for source, dress, more in (("model.json", "knit", ("--z-min", "100", "--z-max", "250")), ("model.json", "hair", ()),
                                    ("frame.json", "tortoise", ()), ("frame.json", "carved", ())):
            report = self.report("render", source, "--dress", dress, "--size", "96,96", "--triangle", "6", "--out", "p.png", *more)
            self.assertGreater(report["triangles"], 500, dress)
            self.assertGreater(read_png(self.read("p.png"))[20:76, 20:76].std(), 5.0, dress)
        self.assertIn("--dress", self.refused("render", "model.json", "--out", "q.png"))

    def test_what_is_no_mesh_is_refused(self):
        self.write("triangle.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        self.assertIn("line 4", self.refused("mesh", "triangle.obj"))
        self.write("fins.obj", CUBE + "f 1 2 6 5\n")
        self.assertIn("third at the edge", self.refused("mesh", "fins.obj"))
        self.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nv 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\n"
                               "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n")
        self.assertIn("has no area", self.refused("mesh", "flat.obj"))
        self.write("alone.json", json.dumps({"format": "annulus wrinkly mesh", "version": 1, "attributes": ["height"],
                                             "points": [{"position_mm": [0, 0, 0], "links": [None] * 4, "values": [0]}]}))
        self.assertIn("linked to no other", self.refused("mesh", "alone.json"))
        self.assertIn("use 0 to 64", self.refused("ist", "--m", "0", "--k", "1000000000", code=2))
        self.assertIn("fewer iterations", self.refused("ist", "--m", "1", "--k", "40", code=2))
        self.refused("mesh", "hexagons:3", code=2)
        self.refused("mesh", "nowhere.json")
        self.refused("render", "regular:4x4", "--out", "p.png", "--k", "99", code=2)
        self.refused("render", "regular:4x4", code=2)
        self.refused("render", "regular:4x4", "--out", "p.bmp", code=2)
        self.refused("fit", "regular:4x4", "--out", "m.json", code=2)
        self.write("mine.png", grey_png(numpy.full((8, 8), 90)))
        before = self.read("mine.png")
        self.assertIn("it is the input itself", self.refused("fit", "regular:4x4", "--image", "mine.png", "--out", "mine.png"))
        self.assertEqual(self.read("mine.png"), before)


if __name__ == "__main__":
    annulus_cli.main()
