#!/usr/bin/python3
"""annulus clay: block, teapot and a model shaped by scripts; reports, files, refusals."""

import json
import unittest

import annulus_cli
from annulus_cli import ProgramTest

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

    def test_a_model_is_shaped(self):
        self.write("booth.toml", '[sim]\nsubject = "head"\nseed = 4\n')
        self.succeeds("scan", "--config", "booth.toml", "--profile", "head", "--out", "head.mcap")
        self.succeeds("fit", "head.mcap", "--out", "head.json", "--no-covariance")
        report = self.report("--in", "head.json")
        self.assertLessEqual(report["source"]["largest_error_mm"], 1e-4)
        self.assertLessEqual(abs(report["source"]["volume_error"]), 1e-7)
        columns, rows = report["source"]["columns"], report["source"]["rows"]
        patch = (rows // 3) * columns + columns // 2
        report = self.report("--in", "head.json", "--ops", self.ops({"op": "push", "patch": patch, "depth_mm": 1,
                                                                     "radius_mm": 10}))
        one = report["operations"][0]
        self.assertLessEqual(abs(one["volume_after_mm3"] / one["volume_before_mm3"] - 1), 1e-12)
        self.assertLess(one["touched"], one["patches"] / 10)

    def test_what_cannot_be_is_told_and_leaves_no_file(self):
        self.ops(PUSH, {**PUSH, "depth_mm": 5})
        self.fails("clay", "--in", "block", "--ops", "ops.json", "--out", "out.json", naming=("operation 1 (push)",))
        self.ops({"op": "push", "patch": 1, "dpth_mm": 1})
        self.fails("clay", "--in", "block", "--ops", "ops.json", naming=("'operations[0].dpth_mm' is not known",))
        self.fails("clay", "--in", "block", "--out", "f.xyz", naming=("its ending is '.xyz'",), status=2)
        self.fails("clay", "--in", "gone.json", naming=("gone.json",))


if __name__ == "__main__":
    annulus_cli.main()
