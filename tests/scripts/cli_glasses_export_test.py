#!/usr/bin/python3
"""glasses export: every file is read by a program that nobody here wrote, or by a few lines that share nothing with ours."""

import json
import math
import os
import re
import shutil
import subprocess
import unittest
import zlib

import annulus_cli
import dcs_trace
from annulus_cli import ProgramTest
from stl_admesh_test import judge

PEERS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "peers")
HAS_PEERS = shutil.which("node") and os.path.isdir(os.path.join(PEERS, "node_modules", "occt-import-js"))
HAS_POPPLER = shutil.which("pdftocairo") and shutil.which("pdftotext") and shutil.which("pdfinfo")
POINTS_PER_MM = 72 / 25.4
LONG = "ANNULUS_LONG" in os.environ
RX = {"format": "annulus-rx", "version": 1, "date": "2026-05-04", "prescriber": "Dr. Tanaka", "refracted_vertex_mm": 12,
      "right": {"sph_d": -4, "cyl_d": -0.75, "axis_deg": 90, "pd_mm": 31.5, "height_mm": 18},
      "left": {"sph_d": -3.25, "prism": {"horizontal_cm_m": 1, "horizontal_base": "in"}, "pd_mm": 32, "height_mm": 18.5},
      "centration": {"status": "estimate"}}


def face_points():
    """A face by hand, station frame: PD 62 mm, ears 150 mm apart."""
    at = {"eye_right": [31, 75, 1600], "eye_left": [-31, 75, 1600], "ear_right": [75, -20, 1605],
          "ear_left": [-75, -20, 1605], "forehead": [0, 95, 1635], "sellion": [0, 92, 1605], "pronasale": [0, 112, 1570]}
    return {name: {"position_mm": p, "source": "given"} for name, p in at.items()}


class Export(ProgramTest):
    def design(self, name="frame.json", *options):
        self.succeeds("glasses", "design", "--out", name, *(options or ("--style", "example4")))
        return name

    def export(self, source, *options):
        return self.succeeds("glasses", "export", source, *options)

    def worn(self):
        """A worn frame in version 1 of the format: steps 1–4 of the paper by hand on face_points()."""
        frame = self.read_json(self.design("worn_frame.json", "--style", "boston", "--width", f"{62 / 1.2}"))
        tilt = math.radians(10)
        c, s = math.cos(tilt), math.sin(tilt)
        rotation = [[1, 0, 0], [0, c, s], [0, -s, c]]
        translation = [0, 88, 1600]

        def in_frame(p):
            d = [p[k] - translation[k] for k in range(3)]
            return [sum(rotation[k][axis] * d[k] for k in range(3)) for axis in range(3)]

        face = face_points()
        worn = {"format": "annulus-worn", "version": 1, "parameters": frame["parameters"],
                "station_from_frame": {"rotation": rotation, "translation_mm": translation},
                "ears_in_frame_mm": {side: in_frame(face[f"ear_{side}"]["position_mm"]) for side in ("right", "left")},
                "face_points": face, "tilt_rad": tilt, "tilt_deg": 10, "forward_shift_mm": 0, "clearance_mm": 1,
                "l6_right_mm": 90, "l6_left_mm": 90,
                "residuals": {f"{n}_mm": 0 for n in ("eye_right", "eye_left", "bridge", "ear_right", "ear_left")}}
        # The paper's frame, whatever details the style has.
        self.write("worn.json", json.dumps(worn))
        return "worn.json"


class Stl(Export):
    def check(self, name):
        found = judge(self.path(name))
        print(f"{name}: {found}")
        for count in ("Total disconnected facets", "Degenerate facets", "Facets reversed", "Backwards edges"):
            self.assertEqual(found[count], 0, f"{name}: {count}")
        self.assertTrue(1e3 < found["Volume"] < 1e5, found)
        return found

    def test_admesh_finds_every_kind_of_frame_closed(self):
        for style in ("example1", "example2", "example3", "example4", "wellington", "aviator", "half-rim-rectangle",
                      "rimless-oval", "sport-wrap"):
            with self.subTest(style):
                self.export(self.design("f.json", "--style", style), "--out", f"{style}.stl", "--force")
                self.check(f"{style}.stl")

    def test_a_fused_skin_is_one_part_of_less_volume(self):
        self.export(self.design(), "--out", "shells.stl")
        self.export("frame.json", "--out", "fused.stl", "--fused")
        shells, fused = self.check("shells.stl"), self.check("fused.stl")
        self.assertEqual((shells["Number of parts"], fused["Number of parts"]), (5, 1))
        self.assertLess(fused["Volume"], shells["Volume"])  # what overlaps counts once
        self.assertGreater(fused["Volume"], 0.9 * shells["Volume"])

    def test_a_wall_that_is_too_thin_is_refused_with_what_to_change(self):
        # s = l1/20 = 2.5 mm: the solid is 0.75·s deep, its bridge and temples a little less.
        self.design("frame.json", "--style", "example2")
        line = self.fails("glasses", "export", "frame.json", "--out", "f.stl", "--min-wall", "1.87",
                          naming=("1.87 mm", "mm thick: design it deeper (--depth 2.", "--force"))
        self.assertIn("frame.json", line)
        self.fails("glasses", "export", "frame.json", "--out", "f.stl", "--min-wall", "1.6",
                   naming=("arm_", "mm thick at x", "--min-wall"))
        note = self.export("frame.json", "--out", "f.stl", "--min-wall", "2", "--force")
        self.assertIn("f.stl: written although", note)
        self.assertEqual(self.export("frame.json", "--out", "g.stl", "--min-wall", "0.9"), "")


class Json(Export):
    def test_the_design_of_a_worn_frame_makes_the_same_bytes(self):
        self.export(self.worn(), "--out", "design.json", "--out", "worn.stl", "--out", "worn.pdf")
        self.export("design.json", "--out", "design.stl", "--out", "again.json")
        self.assertEqual(self.read("design.stl"), self.read("worn.stl"))
        self.assertEqual(self.read("again.json"), self.read("design.json"))

    def test_what_is_neither_a_frame_nor_worn_is_refused_and_nothing_is_written(self):
        self.write("x.json", "{}")
        self.fails("glasses", "export", "x.json", "--out", "f.stl", naming=("x.json",))
        self.design()
        self.fails("glasses", "export", "frame.json", "--out", "f.xyz", naming=(".stl, .step, .dcs, .json or .pdf",))
        self.fails("glasses", "export", "frame.json", "--out", "f.stl", "--out", "f.dcs", naming=("--confirmed-by",))


class Dcs(Export):
    def test_radii_reproduce_the_boxes_of_every_style(self):
        for style in ("example1", "example2", "example3", "example4", "boston", "aviator", "rimless-rectangle"):
            with self.subTest(style):
                self.export(self.design("f.json", "--style", style), "--out", "f.dcs", "--confirmed-by", "M. Sato")
                records, traces = dcs_trace.read(self.path("f.dcs"))
                self.assertEqual((records["REQ"], records["DO"]), ("FIL", "B"))
                n = len(traces["R"])
                self.assertEqual(len(traces["L"]), n)
                for i in range(n):
                    self.assertEqual(traces["L"][(n // 2 - i) % n], traces["R"][i])
                for k, eye in enumerate("RL"):
                    width, height, ed, around = dcs_trace.box(traces[eye])
                    self.assertAlmostEqual(width, dcs_trace.pair(records, "HBOX")[k], delta=0.02)
                    self.assertAlmostEqual(height, dcs_trace.pair(records, "VBOX")[k], delta=0.02)
                    self.assertAlmostEqual(ed, dcs_trace.pair(records, "FED")[k], delta=0.05)
                    self.assertAlmostEqual(around, dcs_trace.pair(records, "CIRC")[k], delta=0.3)

    def test_the_paper_s_round_frame_is_a_circle(self):
        # 0.911·l1/2 is the centre line; the inner outline is d1/2 inside it. l1 = 50, d1 = 2.5.
        self.export(self.design("f.json", "--style", "example2"), "--out", "f.dcs", "--confirmed-by", "M. Sato")
        _, traces = dcs_trace.read(self.path("f.dcs"))
        for radius in traces["R"]:
            self.assertAlmostEqual(radius, 0.911 * 25 - 1.25, delta=0.15)

    def test_no_lab_file_leaves_without_a_name(self):
        self.design()
        for name in ((), ("--confirmed-by", ""), ("--confirmed-by", "  ")):
            self.fails("glasses", "export", "frame.json", "--out", "f.dcs", *name, naming=("--confirmed-by NAME",))

    def test_the_order_is_in_the_file(self):
        self.write("rx.json", json.dumps(RX))
        self.export(self.design("f.json", "--style", "boston"), "--out", "f.dcs", "--rx", "rx.json", "--reference", "K-0042",
                    "--lens-material", "1.67", "--confirmed-by", "M. Sato")
        records, _ = dcs_trace.read(self.path("f.dcs"))
        self.assertEqual(records["JOB"], "K-0042")
        self.assertEqual(records["_CONFIRMED"], "M. Sato")
        self.assertEqual(dcs_trace.pair(records, "SPH"), (-4.0, -3.25))
        self.assertEqual(dcs_trace.pair(records, "CYL"), (-0.75, None))
        self.assertEqual(dcs_trace.pair(records, "AX"), (90.0, None))
        self.assertEqual(dcs_trace.pair(records, "IPD"), (31.5, 32.0))
        self.assertEqual(dcs_trace.pair(records, "OCHT"), (18.0, 18.5))
        self.assertEqual(dcs_trace.pair(records, "PRVM"), (None, 1.0))
        self.assertEqual(dcs_trace.pair(records, "PRVA"), (None, 180.0))  # in, of the left eye, as the viewer sees it

    def test_pupils_of_a_worn_frame_are_an_estimate_until_somebody_confirms(self):
        note = self.export(self.worn(), "--out", "f.dcs", "--confirmed-by", "M. Sato")
        self.assertIn("estimate, confirmed by M. Sato", note)
        records, _ = dcs_trace.read(self.path("f.dcs"))
        for pd in dcs_trace.pair(records, "IPD"):
            self.assertAlmostEqual(pd, 31.0, delta=0.01)


@unittest.skipUnless(HAS_PEERS, "occt-import-js is not installed: ./dev test installs it")
class Step(Export):
    def read_step(self, deflection, *names):
        command = ["node", os.path.join(PEERS, "read_step.mjs"), str(deflection), *map(self.path, names)]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=1000 * annulus_cli.TIME_FACTOR)
        return json.loads(done.stdout)

    def check(self, style, deflection=0.001):
        """The solids' volumes by occt-import-js' triangles against ours. Its triangles lie inside: the finer, the nearer; what
        is 4 mm thick may be meshed more coarsely than what is 2 mm thick."""
        self.export(self.design("f.json", "--style", style), "--out", "f.step", "--force", "--json", "solids.json")
        ours = {body["name"]: body for body in self.read_json("solids.json")["solids"]}
        found = self.read_step(deflection, "f.step")[0]
        self.assertTrue(found["success"])
        self.assertEqual(sorted(s["name"] for s in found["solids"]), sorted(ours))
        for solid in found["solids"]:
            with self.subTest(style=style, body=solid["name"]):
                print(style, solid, ours[solid["name"]])
                self.assertEqual(solid["open_edges"], 0)
                self.assertTrue(ours[solid["name"]]["fused"])
                self.assertAlmostEqual(solid["volume_mm3"] / ours[solid["name"]]["volume_mm3"], 1.0, delta=1e-3)

    def test_another_program_reads_the_paper_s_frame_with_our_volume(self):
        self.check("example4")

    def test_another_program_reads_a_grooved_frame_with_hinges_and_pads_with_our_volume(self):
        self.check("wellington", 0.002)

    @unittest.skipUnless(LONG, "long")
    def test_another_program_reads_every_kind_of_frame_with_our_volume(self):
        for style in ("example1", "example2", "example3", "aviator", "half-rim-rectangle", "rimless-oval", "sport-wrap"):
            self.check(style)

    def test_the_same_design_gives_the_same_bytes_without_date_or_host(self):
        self.export(self.design(), "--out", "a.step")
        self.export("frame.json", "--out", "b.step")
        text = self.read("a.step")
        self.assertEqual(self.read("b.step"), text)
        head = text[:2000].decode()
        self.assertRegex(head, r"FILE_NAME\('annulus frame','2000-01-01T00:00:00'")
        self.assertIn("PRODUCT('frame','frame'", head)
        self.assertNotIn(os.uname().nodename, text.decode())
        self.assertNotIn(self.folder, text.decode())


@unittest.skipUnless(HAS_POPPLER, "poppler is not installed: apt-get install poppler-utils")
class Pdf(Export):
    def poppler(self, *arguments):
        return subprocess.run(arguments, cwd=self.folder, capture_output=True, text=True, check=True).stdout

    def text(self, name):
        return re.sub(r"\s+", " ", self.poppler("pdftotext", "-layout", name, "-"))

    def paths(self, name, page):
        """Every path of a page in mm: (attributes, points)."""
        self.poppler("pdftocairo", "-svg", "-f", str(page), "-l", str(page), name, "page.svg")
        svg = self.read("page.svg").decode()
        found = []
        for tag in re.findall(r"<path [^>]*>", svg):
            attributes = dict(re.findall(r'([\w-]+)="([^"]*)"', tag))
            numbers = [float(n) for n in re.findall(r"-?\d+(?:\.\d+)?", attributes.get("d", ""))]
            a, b, c, d, e, f = 1, 0, 0, 1, 0, 0
            if "transform" in attributes:
                a, b, c, d, e, f = (float(n) for n in re.findall(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", attributes["transform"]))
            corners = list(zip(numbers[::2], numbers[1::2]))
            found.append((attributes, [((a * x + c * y + e) / POINTS_PER_MM, (b * x + d * y + f) / POINTS_PER_MM)
                                       for x, y in corners]))
        return found

    def sizes(self, name, page):
        """Width and height of every closed rectangle of lines on the page."""
        rectangles = []
        for _, corners in self.paths(name, page):
            if len(corners) < 4 or len(corners) > 6:
                continue
            xs, ys = {round(x, 2) for x, _ in corners}, {round(y, 2) for _, y in corners}
            if len(xs) == 2 and len(ys) == 2:
                rectangles.append((max(xs) - min(xs), max(ys) - min(ys)))
        return rectangles

    def test_the_drawing_is_one_to_one(self):
        self.export(self.design(), "--out", "f.pdf", "--out", "f.dcs", "--confirmed-by", "M. Sato")
        info = self.poppler("pdfinfo", "-f", "1", "-l", "3", "f.pdf")
        self.assertEqual(len(re.findall(r"Page\s+\d size:\s+841\.8\d* x 595\.2\d* pts", info)), 3)
        self.assertNotIn(b"UserUnit", self.read("f.pdf"))
        records, _ = dcs_trace.read(self.path("f.dcs"))
        wanted = dcs_trace.pair(records, "HBOX")[0], dcs_trace.pair(records, "VBOX")[0]
        for page in (1, 2):
            near = [s for s in self.sizes("f.pdf", page) if math.dist(s, wanted) <= 0.1]
            self.assertTrue(near, f"page {page} has no box of {wanted}: {self.sizes('f.pdf', page)}")
        for page in (1, 2, 3):
            self.assertTrue([s for s in self.sizes("f.pdf", page) if abs(s[0] - 50) < 0.1 and abs(s[1] - 2) < 0.1], page)

    def test_dimension_lines_are_as_long_as_they_say(self):
        self.export(self.design(), "--out", "f.pdf")
        lengths = [math.dist(*corners) for page in (1, 2, 3) for _, corners in self.paths("f.pdf", page) if len(corners) == 2]
        text = self.text("f.pdf")
        said = [float(n) for n in re.findall(r"(?:A|B|DBL) (\d+\.\d)", text)]
        self.assertGreaterEqual(len(said), 5)
        for value in said:
            self.assertTrue([length for length in lengths if abs(length - value) <= 0.1], f"no line is {value} mm long")

    def test_the_outline_is_the_frame_s(self):
        # The paper's frame without hinge: its rims' outer width is 2·l1 + l0 + d1, l1 = 50 mm: 112.5 mm and the arms beyond.
        self.export(self.design("f.json", "--style", "example1"), "--out", "f.pdf", "--out", "f.stl")
        solid = judge(self.path("f.stl"))
        self.assertGreater(solid["Volume"], 0)
        size = subprocess.run(["admesh", self.path("f.stl")], capture_output=True, text=True, check=True).stdout
        low, high = (float(n) for n in re.search(r"Min X = (-?[\d.]+), Max X = +(-?[\d.]+)", size).groups())
        xs = self.strokes("f.pdf", 0.3)
        self.assertAlmostEqual(max(xs) - min(xs), high - low, delta=0.02)

    def strokes(self, name, width_mm):
        """x in mm of every line of that width on the first page, from the page's own operators: poppler's programs move lines to
        whole pixels."""
        data = self.read(name)
        begin = data.index(b"stream", data.index(b"FlateDecode")) + len(b"stream\n")
        tokens = zlib.decompressobj().decompress(data[begin:]).decode("latin-1").split()
        width, xs = 0.0, []
        for k, token in enumerate(tokens):
            if token == "w":
                width = float(tokens[k - 1]) / POINTS_PER_MM
            elif token in ("m", "l") and abs(width - width_mm) < 0.01:
                xs.append(float(tokens[k - 2]) / POINTS_PER_MM)
        return xs

    def test_pupils_are_marked_as_an_estimate_until_confirmed(self):
        self.export(self.worn(), "--out", "f.pdf")
        self.assertIn("estimate, confirm by optician", self.text("f.pdf"))
        self.export("worn.json", "--out", "f.pdf", "--confirmed-by", "M. Sato")
        text = self.text("f.pdf")
        self.assertIn("confirmed by M. Sato", text)
        self.assertNotIn("estimate", text)
        self.assertIn("31.0", text)

    def test_the_order_sheet_has_the_order_and_says_whether_it_is_confirmed(self):
        self.write("rx.json", json.dumps(RX))
        options = ("--rx", "rx.json", "--lens-material", "1.67", "--reference", "K-0042")
        self.export(self.worn(), "--out", "f.json", "--order-sheet", "o.pdf", *options)
        text = self.text("o.pdf")
        for word in ("NOT CONFIRMED", "K-0042", "-4.00", "-0.75", "90°", "1.00 in", "31.5", "18.5", "Dr. Tanaka", "1.67", "base curve"):
            self.assertIn(word, text)
        self.assertRegex(text, r"\d+□\d+-\d+")
        self.export("worn.json", "--out", "f.json", "--order-sheet", "o.pdf", "--confirmed-by", "M. Sato", *options)
        text = self.text("o.pdf")
        self.assertIn("confirmed by M. Sato", text)
        self.assertNotIn("NOT CONFIRMED", text)

    def test_the_same_source_gives_the_same_bytes_and_no_date(self):
        self.worn()
        for name in ("a", "b"):
            self.export("worn.json", "--out", f"{name}.pdf", "--order-sheet", f"{name}_order.pdf")
        for kind in ("", "_order"):
            self.assertEqual(self.read(f"a{kind}.pdf"), self.read(f"b{kind}.pdf"))
            self.assertIn("2000", re.search(r"CreationDate:.*", self.poppler("pdfinfo", f"a{kind}.pdf")).group(0))


if __name__ == "__main__":
    annulus_cli.main()
