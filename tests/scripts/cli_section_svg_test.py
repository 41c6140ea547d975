#!/usr/bin/python3
"""section --svg: a picture in true scale of an elliptic cylinder, whose outline is known."""

import math
import os
import re
import xml.etree.ElementTree as ElementTree

import annulus_cli
from annulus_cli import EllipticCylinder, ProgramTest

CYLINDER = EllipticCylinder()
SVG = "{http://www.w3.org/2000/svg}"


class SectionSvg(ProgramTest):
    def setUp(self):
        super().setUp()
        self.import_cylinder(CYLINDER)
        self.succeeds("fit", "scan.mcap", "--out", "model.json")

    def test_the_picture_is_an_svg_whose_outline_is_the_ellipse_in_mm(self):
        report = self.succeeds_json("section", "model.json", "--z", "200", "--svg", "section.svg")
        self.assertAlmostEqual(report["perimeter_mm"], CYLINDER.perimeter, delta=0.5)
        picture = ElementTree.parse(os.path.join(self.folder, "section.svg")).getroot()
        self.assertEqual(picture.tag, SVG + "svg")
        self.assertEqual(picture.get("version"), "1.1")
        width, height = (float(v) for v in picture.get("viewBox").split()[2:])
        self.assertEqual((picture.get("width"), picture.get("height")), (f"{width:.3f}mm", f"{height:.3f}mm"))
        outlines = [p.get("d") for p in picture.iter(SVG + "path") if p.get("class") in ("measured", "inferred")]
        points = []
        for outline in outlines:  # M x,y and C with the end as its third point: the ends lie on the wall
            self.assertRegex(outline, r"^M[-0-9.,]+( C[-0-9.,]+ [-0-9.,]+ [-0-9.,]+)+( Z)?$")
            points += [tuple(float(c) for c in end.split(",")) for end in re.findall(r"([-0-9.]+,[-0-9.]+)(?= C| Z|$)", outline)]
        self.assertGreater(len(points), 16)
        for x, y in points:
            self.assertAlmostEqual(math.hypot(x, y), CYLINDER.radius(math.atan2(-y, x)), delta=0.5)
        text = " ".join(t.text for t in picture.iter(SVG + "text"))
        for word in ("front", "back", "left", "right", "perimeter", "tape", "area", "±", "Section at z = 200.0 mm"):
            self.assertIn(word, text)

    def test_the_same_section_gives_the_same_bytes_and_a_wrong_height_no_file(self):
        for name in ("a.svg", "b.svg"):
            self.succeeds("section", "model.json", "--z", "123.4", "--svg", name)
        with open(os.path.join(self.folder, "a.svg"), "rb") as a, open(os.path.join(self.folder, "b.svg"), "rb") as b:
            self.assertEqual(a.read(), b.read())
        self.fails("section", "model.json", "--z", "1000", "--svg", "no.svg", naming=("0", "400"))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "no.svg")))


if __name__ == "__main__":
    annulus_cli.main()
