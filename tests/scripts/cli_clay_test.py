#!/usr/bin/python3
"""annulus clay: block, teapot, models and frames shaped by scripts; the way back; undo; reports, files, refusals."""

import json
import unittest

import annulus_cli
from annulus_cli import EllipticCylinder, ProgramTest

PUSH = {"op": "push", "model": 1, "patch": 21, "u": 0.0, "v": 0.0, "depth_mm": 0.2, "radius_mm": 0.8}


class Clay(ProgramTest):
    def ops(self, *operations, **more):
        self.write("ops.json", json.dumps({"operations": operations, **more}))
        return "ops.json"

    def report(self, *arguments):
        self.succeeds("clay", *arguments, "--json", "report.json")
        return self.read_json("report.json")

    def test_a_push_keeps_the_blocks_volume(self):
        report = self.report("--in", "block", "--ops", self.ops(PUSH, {**PUSH, "model": 2}), "--out", "out.json")
        self.assertEqual(report["source"]["in"], "block")
        self.assertEqual([one["op"] for one in report["operations"]], ["push", "push"])
        for one in report["operations"]:
            self.assertAlmostEqual(one["volume_before_mm3"], 108.0, delta=1e-10)
            self.assertAlmostEqual(one["volume_after_mm3"], 108.0, delta=1e-10)
            self.assertEqual(one["moved_mm3"], 0)
            self.assertGreater(one["k"], 0)
        self.assertLessEqual(report["joins"]["largest_gap_mm"], 1e-9)
        self.assertLessEqual(report["joins"]["largest_kink_rad"], 1e-6)
        self.assertLessEqual(report["joins"]["largest_kink_elsewhere_rad"], 1e-3)

    def test_what_is_no_place_or_name_is_refused_before_anything_is_written(self):
        for key, value in (("near_mm", [1e160, 0, 0]), ("near_mm", [0, -2e6, 0])):
            push = {"op": "push", key: value, "depth_mm": 0.1, "radius_mm": 0.6}
            self.fails("clay", "--in", "block", "--ops", self.ops(push), "--out", "x.json", naming=("near_mm", "kilometre"))
        for arguments in (("--out", "x.json", "--out", "x.foo"), ("--girth", "nan"), ("--undo", "-1")):
            done = self.run_program("clay", "--in", "block", *arguments)
            self.assertEqual(done.returncode, 2, done.stderr)
        self.assertNotIn("x.json", self.listing())

    def test_the_teapot_says_that_its_volume_is_signed(self):
        report = self.report("--in", "teapot")
        # numpy, see tests/modeling_clay/clay_body_test.cpp
        self.assertAlmostEqual(report["volume_mm3"], 26.18473881628571, places=10)
        self.assertIn("signed", report["source"]["note"])

    def test_girths_are_reported_before_and_after(self):
        report = self.report("--in", "block", "--ops", self.ops({"op": "add", "patch": 21, "volume_mm3": 2,
                                                                 "radius_mm": 0.8}), "--girth", "-1.5,0.1")
        before, after = report["girths_before"], report["operations"][0]["girths"]
        self.assertAlmostEqual(before[0]["perimeter_mm"], 24.0, places=9)
        self.assertAlmostEqual(after[0]["tape_mm"], 24.0, places=9)
        self.assertEqual(before[1]["perimeter_mm"], 0)
        self.assertGreater(after[1]["perimeter_mm"], 1.0)

    def test_a_script_replays_to_the_byte_and_goes_on(self):
        ops = self.ops(PUSH)
        for name in ("a.json", "b.json"):
            self.succeeds("clay", "--in", "block", "--ops", ops, "--out", name)
        self.assertEqual(self.read("a.json"), self.read("b.json"))
        self.succeeds("clay", "--in", "a.json", "--ops", ops, "--out", "twice.json")
        self.assertEqual(len(self.read_json("twice.json")["history"]), 2)

    def test_a_hole_goes_through_and_is_filled_again(self):
        hole = {"op": "hole", "through": True, "patch": 14, "radius_mm": 0.5}
        report = self.report("--in", "block", "--ops", self.ops(hole), "--out", "ring.json", "--girth", "-1.5")
        one = report["operations"][0]
        self.assertAlmostEqual(one["volume_after_mm3"], 108.0, delta=1e-10)
        # The block's outline and that of the hole, 4 r sqrt(pi), swollen by less than 1 %.
        self.assertAlmostEqual(one["girths"][0]["perimeter_mm"], 24 + 3.545, delta=0.3)
        self.assertEqual(len(self.read_json("ring.json")["holes"]), 1)
        self.ops({**PUSH, "patch": 14, "u": 0.5, "v": 0.5})
        self.fails("clay", "--in", "ring.json", "--ops", "ops.json", naming=("patch 14", "is in a hole"))
        report = self.report("--in", "ring.json", "--ops", self.ops({**hole, "how": "close"}), "--out", "full.json")
        self.assertAlmostEqual(report["area_mm2"], 144.0, delta=1e-9)
        self.assertTrue(self.read_json("full.json")["holes"][0]["filled"])

    def test_meshes_are_closed_and_hold_the_volume(self):
        self.succeeds("clay", "--in", "block", "--ops", self.ops(PUSH), "--out", "skin.obj", "--out", "skin.stl",
                      "--out", "skin.ply")
        vertices, volume, edges = [], 0.0, {}
        for line in self.read("skin.obj").decode().splitlines():
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([float(x) for x in words[1:4]])
            elif words[:1] == ["f"]:
                face = [int(word.split("/")[0]) - 1 for word in words[1:]]
                a, b, c = (vertices[n] for n in face)
                volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                           + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
                for n in range(3):
                    edge = (face[n], face[(n + 1) % 3])
                    edges[edge] = edges.get(edge, 0) + 1
        self.assertTrue(all(count == 1 and (b, a) in edges for (a, b), count in edges.items()))
        self.assertAlmostEqual(volume, 108.0, delta=0.05)

    def head(self):
        """A fitted head, head.json."""
        self.write("booth.toml", '[sim]\nsubject = "head"\nseed = 4\n')
        self.succeeds("scan", "--config", "booth.toml", "--profile", "head", "--out", "head.mcap")
        self.succeeds("fit", "head.mcap", "--out", "head.json")

    def test_a_model_is_shaped_and_comes_back(self):
        self.head()
        report = self.report("--in", "head.json", "--out", "head_clay.json", "--out-model", "same.json")
        self.assertLessEqual(report["source"]["largest_error_mm"], 1e-4)
        self.assertLessEqual(abs(report["source"]["volume_error"]), 1e-7)
        self.assertFalse(report["source"]["exact"])
        # Untouched, it comes back to the bit, with all that was measured.
        self.assertLessEqual(abs(report["model"]["volume_error"]), 1e-7)
        self.assertEqual(report["model"]["largest_error_mm"], 0)
        same, head = self.read_json("same.json"), self.read_json("head.json")
        self.assertEqual(same["provenance"].pop("method"), head["provenance"].pop("method") + "+clay")
        self.assertEqual(same, head)

        columns, rows = report["source"]["columns"], report["source"]["rows"]
        z_min, z_max = report["model"]["z_min_mm"], report["model"]["z_max_mm"]
        patch = (rows // 3) * columns + columns // 2
        z = z_min + (z_max - z_min) * (rows // 3 + 0.5) / rows
        ops = self.ops({"op": "push", "model": 2, "patch": patch, "depth_mm": 4, "radius_mm": 30})
        report = self.report("--in", "head.json", "--ops", ops, "--girth", z, "--out-model", "shaped.json")
        one, model = report["operations"][0], report["model"]
        self.assertLessEqual(abs(one["volume_after_mm3"] / one["volume_before_mm3"] - 1), 1e-12)
        self.assertLess(one["touched"], one["patches"] / 5)
        self.assertLessEqual(model["largest_error_mm"], 0.1)
        self.assertTrue(model["covariance_kept"])
        self.assertLessEqual(abs(model["volume_error"]), 1e-6)
        self.assertEqual(self.read_json("shaped.json")["measured"][0]["rows"], head["measured"][0]["rows"])
        # Live girths of the clay against sections of both models.
        for name, girth in (("head.json", report["girths_before"][0]), ("shaped.json", one["girths"][0])):
            section = self.succeeds_json("section", name, "--z", z)
            self.assertAlmostEqual(section["perimeter_mm"], girth["perimeter_mm"], delta=0.05)
            self.assertAlmostEqual(section["tape_mm"], girth["tape_mm"], delta=0.05)
            self.assertGreater(section["tape_sigma_mm"], 0)
        self.assertLess(one["girths"][0]["perimeter_mm"], report["girths_before"][0]["perimeter_mm"] - 0.5)
        self.succeeds("measure", "shaped.json", "--out", "table.json")
        self.assertGreater(len(self.read_json("table.json")["measurements"]), 10)
        self.succeeds("render", "shaped.json", "--view", "front", "--size", 64, "--out", "shaped.png")

        # The same from a saved body, in two sittings.
        self.succeeds("clay", "--in", "head_clay.json", "--ops", ops, "--out", "shaped_clay.json")
        self.fails("clay", "--in", "shaped_clay.json", "--out-model", "x.json", naming=("--made-of",), status=2)
        again = self.report("--in", "shaped_clay.json", "--made-of", "head.json", "--out-model", "again.json")
        self.assertAlmostEqual(again["model"]["volume_mm3"] / model["volume_mm3"], 1, delta=1e-9)

    def test_operations_are_undone_to_the_byte(self):
        second = {"op": "twist", "angle_deg": 5, "from": [-3, 0, -1], "to": [3, 0, -1]}
        self.succeeds("clay", "--in", "block", "--ops", self.ops(PUSH), "--out", "one.json")
        self.succeeds("clay", "--in", "one.json", "--ops", self.ops(second, PUSH), "--out", "three.json")
        self.succeeds("clay", "--in", "block", "--out", "none.json")
        for count, name in ((2, "one.json"), (3, "none.json")):
            report = self.report("--in", "three.json", "--made-of", "block", "--undo", count, "--out", "back.json")
            self.assertEqual(report["source"]["undone"], count)
            self.assertEqual(self.read("back.json"), self.read(name))
        self.fails("clay", "--in", "three.json", "--undo", "1", naming=("--made-of",), status=2)
        self.fails("clay", "--in", "block", "--undo", "1", naming=("no clay body",), status=2)
        self.fails("clay", "--in", "three.json", "--made-of", "block", "--undo", "4", naming=("has 3 operations, not 4",))
        self.fails("clay", "--in", "three.json", "--made-of", "teapot", "--undo", "1", naming=("made of",))

    def test_both_sides_and_masks_hold_in_a_script(self):
        ops = self.ops({**PUSH, "patch": 19, "u": 0.5, "v": 0.5, "radius_mm": 0.5}, mirrored=True,
                       masks=[{"patch": 21, "u": 0.5, "v": 0.5, "radius_mm": 0.4}])
        self.succeeds("clay", "--in", "block", "--ops", ops, "--out", "out.obj")
        points = [[float(x) for x in line.split()[1:4]] for line in self.read("out.obj").decode().splitlines()
                  if line.startswith("v ")]
        dents = [p for p in points if p[2] > -1 and p[2] < -0.15]
        self.assertTrue(any(p[0] < 0 for p in dents))
        for x, y, z in dents:
            self.assertTrue(any(abs(p[0] + x) + abs(p[1] - y) + abs(p[2] - z) < 1e-6 for p in dents), (x, y, z))
        # Patch 21 is from x = 0 to 1, y = 0 to 1; without the mask the rim goes through its middle.
        held = [p for p in points if p[2] > -1 and (p[0] - 0.5) ** 2 + (p[1] - 0.5) ** 2 < 0.2 ** 2]
        self.assertTrue(held and all(p[2] == 0 for p in held))

    def test_a_frames_parts_are_clay_as_they_are(self):
        self.succeeds("glasses", "design", "--style", "round", "--size", "medium", "--out", "frame.json")
        rim = self.report("--in", "frame.json", "--part", "rim_right", "--ops",
                          self.ops({"op": "push", "patch": 3, "depth_mm": 0.1, "radius_mm": 1.5}), "--out", "rim.stl")
        self.assertTrue(rim["source"]["exact"])
        one = rim["operations"][0]
        self.assertLessEqual(abs(one["volume_after_mm3"] / one["volume_before_mm3"] - 1), 1e-12)
        whole = self.report("--in", "frame.json")
        self.assertGreater(whole["volume_mm3"], 2 * rim["volume_mm3"])
        self.assertIn("counts twice", whole["source"]["note"])
        self.fails("clay", "--in", "frame.json", "--part", "lens_left", naming=("closed",))
        self.fails("clay", "--in", "frame.json", "--part", "rim", naming=("rim_left",))

    def test_a_model_of_the_papers_method_is_clay_as_it_is(self):
        self.import_cylinder(EllipticCylinder())
        self.succeeds("fit", "scan.mcap", "--out", "paper.json", "--method", "paper")
        report = self.report("--in", "paper.json", "--out-model", "back.json", "--girth", 200)
        self.assertTrue(report["source"]["exact"])
        self.assertLessEqual(report["source"]["largest_error_mm"], 1e-9)
        section = self.succeeds_json("section", "back.json", "--z", 200)
        self.assertAlmostEqual(section["perimeter_mm"], report["girths_before"][0]["perimeter_mm"], delta=0.05)

    def test_what_cannot_be_is_told_and_leaves_no_file(self):
        self.ops(PUSH, {**PUSH, "depth_mm": 5})
        self.fails("clay", "--in", "block", "--ops", "ops.json", "--out", "out.json", naming=("operation 1 (push)",))
        self.ops({"op": "push", "patch": 1, "dpth_mm": 1})
        self.fails("clay", "--in", "block", "--ops", "ops.json", naming=("'operations[0].dpth_mm' is not known",))
        self.fails("clay", "--in", "block", "--out", "f.xyz", naming=("its ending is '.xyz'",), status=2)
        self.fails("clay", "--in", "gone.json", naming=("gone.json",))


if __name__ == "__main__":
    annulus_cli.main()
