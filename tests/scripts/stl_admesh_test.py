#!/usr/bin/python3
"""admesh, which nobody here wrote, finds the frame's STL closed, consistently oriented and of positive volume."""

import os
import re
import subprocess

import annulus_cli
from annulus_cli import ProgramTest


def judge(path):
    """What admesh counts in the file as it is: -e exact edges, -d directions, -v normals and volume; nothing is repaired."""
    text = subprocess.run(["admesh", "-edv", path], capture_output=True, text=True, check=True).stdout
    found = {}
    for name in ("Number of facets", "Total disconnected facets", "Degenerate facets", "Facets reversed", "Backwards edges",
                 "Number of parts", "Volume"):
        found[name] = float(re.search(rf"{name}\s*:\s*(-?[\d.]+)", text).group(1))
    return found


TETRAHEDRON = [((0, 0, 0), (0, 9, 0), (9, 0, 0)), ((0, 0, 0), (9, 0, 0), (0, 0, 9)), ((0, 0, 0), (0, 0, 9), (0, 9, 0)),
               ((9, 0, 0), (0, 9, 0), (0, 0, 9))]


class StlOfAFrame(ProgramTest):
    def write_stl(self, name, triangles):
        lines = ["solid t"]
        for triangle in triangles:
            corners = [f"vertex {x} {y} {z}" for x, y, z in triangle]
            lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
        self.write(name, "\n".join([*lines, "endsolid t", ""]))
        return self.path(name)

    def test_the_judge_tells_a_closed_from_an_open_and_an_inverted_solid(self):
        closed = judge(self.write_stl("closed.stl", TETRAHEDRON))
        self.assertEqual(closed["Total disconnected facets"], 0)
        self.assertAlmostEqual(closed["Volume"], 9**3 / 6, delta=1e-3)
        self.assertEqual(judge(self.write_stl("open.stl", TETRAHEDRON[:3]))["Total disconnected facets"], 3)
        self.assertLess(judge(self.write_stl("inverted.stl", [t[::-1] for t in TETRAHEDRON]))["Volume"], 0)

    def check_solid(self, name):
        found = judge(self.path(name))
        print(f"{name}: {found}")
        for count in ("Total disconnected facets", "Degenerate facets", "Facets reversed", "Backwards edges"):
            self.assertEqual(found[count], 0, f"{name}: {count}")
        self.assertGreater(found["Number of facets"], 100)
        # A frame of some grams of acetate (1.3 g/cm³): between 1 and 100 cm³.
        self.assertTrue(1e3 < found["Volume"] < 1e5, found)

    def test_the_frame_of_the_demo_s_head_is_a_closed_solid(self):
        self.succeeds("demo", "--subject", "head", "--seed", "3", "--out", "demo")
        stls = [n for n in os.listdir(self.path("demo")) if n.endswith(".stl")]
        self.assertTrue(stls)
        for name in stls:
            self.check_solid(f"demo/{name}")
        worn = [n for n in os.listdir(self.path("demo")) if "worn" in n.lower() and n.endswith(".json")]
        self.assertTrue(worn)
        self.succeeds("glasses", "export", f"demo/{worn[0]}", "--out", "exported.stl")
        self.check_solid("exported.stl")


if __name__ == "__main__":
    annulus_cli.main()
