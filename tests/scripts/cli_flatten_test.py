#!/usr/bin/python3
"""flatten: pieces of an elliptic cylinder, whose flat pieces are rectangles of known size, in every format."""

import json
import os
import xml.etree.ElementTree as ElementTree

import annulus_cli
from annulus_cli import EllipticCylinder, ProgramTest

CYLINDER = EllipticCylinder()
SVG = "{http://www.w3.org/2000/svg}"
QUARTERS = ((0, 90), (90, 180), (180, 270), (270, 360))


def place(theta, z):
    return {"theta_deg": theta, "z_mm": z}


def pattern():
    """Four panels around the cylinder, z from 100 to 300 mm, sewn to each other."""
    lines = {f"seam_{a}": {"places": [place(a, 100), place(a, 300)], "notches": [0.5]} for a, _ in QUARTERS}
    for a, b in QUARTERS:
        lines[f"foot_{a}"] = {"places": [place(a, 100), place((a + b) / 2, 100), place(b, 100)]}
        lines[f"head_{a}"] = {"places": [place(a, 300), place((a + b) / 2, 300), place(b, 300)]}
    pieces = [{"id": f"panel_{a}", "outline": [f"foot_{a}", f"seam_{b % 360}", f"-head_{a}", f"-seam_{a}"]}
              for a, b in QUARTERS]
    return {"format": "annulus pattern", "version": 1, "name": "tube", "element_mm": 12, "allowance_mm": 10,
            "lines": lines, "pieces": pieces}


def read_dxf(text):
    """R12 entities as lists of (code, value); checks the structure that the format's reference asks for."""
    lines = text.splitlines()
    assert len(lines) % 2 == 0
    groups = [(int(lines[k]), lines[k + 1]) for k in range(0, len(lines), 2)]
    assert groups[-1] == (0, "EOF")
    sections, entities, here = [], [], None
    for k, (code, value) in enumerate(groups):
        if (code, value) == (0, "SECTION"):
            here = groups[k + 1][1]
            sections.append(here)
        elif (code, value) == (0, "ENDSEC"):
            here = None
        elif here == "ENTITIES":
            if code == 0:
                entities.append((value, []))
            elif entities:
                entities[-1][1].append((code, value))
    assert sections == ["HEADER", "TABLES", "ENTITIES"], sections
    layers = {groups[k + 1][1] for k, group in enumerate(groups) if group == (0, "LAYER") and groups[k + 1][0] == 2}
    open_chain = False
    for name, values in entities:
        assert dict(values)[8] in layers
        if name == "POLYLINE":
            assert not open_chain and (66, "1") in values
            open_chain = True
        elif name == "VERTEX":
            assert open_chain
        elif name == "SEQEND":
            open_chain = False
        else:
            assert name in ("LINE", "TEXT") and not open_chain, name
    return entities


class Flatten(ProgramTest):
    def setUp(self):
        super().setUp()
        self.import_cylinder(CYLINDER)
        self.succeeds("fit", "scan.mcap", "--out", "model.json")
        with open(os.path.join(self.folder, "pattern.json"), "w", encoding="utf-8") as file:
            json.dump(pattern(), file)

    def path(self, name):
        return os.path.join(self.folder, name)

    def test_the_pieces_have_the_cylinders_measures_in_every_format(self):
        names = [f"tube.{ending}" for ending in ("svg", "pdf", "dxf", "json", "png")]
        outs = [word for name in names for word in ("--out", name)]
        report = self.succeeds_json("flatten", "model.json", "--pattern", "pattern.json", *outs)
        self.assertEqual(len(report["pieces"]), 4)
        self.assertEqual(len(report["seams"]), 4)
        around = sum(piece["flat_area_mm2"] for piece in report["pieces"]) / 200
        self.assertAlmostEqual(around, CYLINDER.perimeter, delta=0.002 * CYLINDER.perimeter)
        for seam in report["seams"]:
            self.assertLess(seam["mismatch_mm"], 0.1)
            self.assertAlmostEqual(seam["flat_mm"][0], 200, delta=1)
        with open(self.path("tube.dxf"), encoding="ascii") as file:
            entities = read_dxf(file.read())
        cut = [dict(values) for name, values in entities if name == "VERTEX" and dict(values)[8] == "CUT"]
        heights = [float(v[20]) for v in cut]
        self.assertAlmostEqual(max(heights) - min(heights), 220, delta=2)
        self.assertEqual(sum(name == "LINE" and dict(values)[8] == "NOTCH" for name, values in entities), 8)
        picture = ElementTree.parse(self.path("tube.svg")).getroot()
        self.assertTrue(picture.get("width").endswith("mm"))
        square = [p for p in picture.iter(SVG + "polygon") if p.get("class") == "check"]
        corners = [tuple(map(float, pair.split(","))) for pair in square[0].get("points").split()]
        self.assertAlmostEqual(corners[1][0] - corners[0][0], 100, places=3)
        with open(self.path("tube.pdf"), "rb") as file:
            self.assertEqual(file.read(5), b"%PDF-")
        with open(self.path("tube.png"), "rb") as file:
            self.assertEqual(file.read(4), b"\x89PNG")

    def test_the_same_pattern_on_a_second_body_gets_its_own_files(self):
        report = self.succeeds_json("flatten", "model.json", "--pattern", "pattern.json", "--model2", "model.json",
                                    "--out", "tube.dxf")
        self.assertEqual(report["model2"]["energy_n_mm"], report["energy_n_mm"])
        with open(self.path("tube.dxf"), "rb") as one, open(self.path("tube_2.dxf"), "rb") as other:
            self.assertEqual(one.read(), other.read())

    def test_a_divided_piece_is_sewn_and_its_neighbours_get_notches(self):
        divided = pattern()
        divided["pieces"][0]["divisions"] = [{"from": {"line": "seam_0", "share": 0.3},
                                              "to": {"line": "seam_90", "share": 0.3}, "through": [place(45, 160)]}]
        self.write("divided.json", json.dumps(divided))
        report = self.succeeds_json("flatten", "model.json", "--pattern", "divided.json", "--out", "tube.dxf",
                                    "--save-pattern", "saved.json")
        self.assertEqual([piece["id"] for piece in report["pieces"]],
                         ["panel_0.1", "panel_0.2", "panel_90", "panel_180", "panel_270"])
        division = [seam for seam in report["seams"] if seam["line"] == "panel_0 division 1"]
        self.assertEqual(division[0]["pieces"], ["panel_0.1", "panel_0.2"])
        for seam in report["seams"]:
            self.assertLess(seam["mismatch_mm"], 0.1)
        lower, upper = (sum(piece["flat_area_mm2"] for piece in report["pieces"] if piece["id"] == part)
                        for part in ("panel_0.1", "panel_0.2"))
        self.assertAlmostEqual(lower / (lower + upper), 0.3, delta=0.01)
        with open(self.path("tube.dxf"), encoding="ascii") as file:
            entities = read_dxf(file.read())
        # Four seams with a notch each, on both sides; the division's own; and where it ends on the two neighbours.
        self.assertEqual(sum(name == "LINE" and dict(values)[8] == "NOTCH" for name, values in entities), 8 + 2 + 2)
        again = self.succeeds_json("flatten", "model.json", "--pattern", "saved.json")
        self.assertEqual(again["energy_n_mm"], report["energy_n_mm"])

    def test_wrong_input_is_refused(self):
        self.fails("flatten", "model.json", "--pattern", "model.json", naming=("model.json",))
        wrong = pattern()
        wrong["lines"]["seam_0"]["places"][0]["z_mm"] = 9000
        with open(self.path("wrong.json"), "w", encoding="utf-8") as file:
            json.dump(wrong, file)
        self.fails("flatten", "model.json", "--pattern", "wrong.json", naming=("seam_0", "9000"))


if __name__ == "__main__":
    annulus_cli.main()
