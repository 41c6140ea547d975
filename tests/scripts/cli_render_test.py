#!/usr/bin/python3
"""render on a scanned head of the simulated booth: methods, looks, extra outputs, batches, and every refusal."""

import json

import annulus_cli
import numpy
from annulus_cli import ProgramTest
from png_image import read_png

RX = {"format": "annulus-rx", "version": 1, "date": "2026-05-04", "prescriber": "Dr. Tanaka", "refracted_vertex_mm": 12,
      "right": {"sph_d": -4, "cyl_d": -0.75, "axis_deg": 90}, "left": {"sph_d": -3.5},
      "centration": {"status": "estimate"}}


class Render(ProgramTest):
    files = {}

    def setUp(self):
        super().setUp()
        if not Render.files:
            self.write("booth.toml", '[sim]\nsubject = "head"\nseed = 4\n')
            self.write("rx.json", json.dumps(RX))
            self.succeeds("scan", "--config", "booth.toml", "--profile", "head", "--out", "head.mcap")
            self.succeeds("fit", "head.mcap", "--out", "head.json")
            self.succeeds("glasses", "design", "--style", "boston", "--size", "medium", "--out", "frame.json")
            self.succeeds("glasses", "fit", "head.json", "--frame", "frame.json", "--size-free", "--out", "worn.json")
            self.succeeds("glasses", "fit", "head.json", "--frame", "frame.json", "--size-free", "--rx", "rx.json", "--out",
                          "minus.json")
            Render.files = {name: self.read(name) for name in ("head.json", "worn.json", "minus.json", "head.mcap")}
        for name, content in Render.files.items():
            self.write(name, content)

    def picture(self, *options, out="p.png", worn="worn.json", view="front", size=120):
        self.succeeds("render", "head.json", "--worn", worn, "--view", view, "--size", str(size), "--out", out, *options)
        return read_png(self.read(out))

    def test_both_methods_draw_the_same_head_in_the_same_place(self):
        self.picture("--alpha", "za.png")
        self.picture("--alpha", "ta.png", "--method", "trace", "--samples", "16")
        a, b = read_png(self.read("za.png")) / 65535.0, read_png(self.read("ta.png")) / 65535.0
        self.assertEqual(a.shape, (120, 120, 1))
        self.assertGreater(a.mean(), 0.3)
        both = numpy.minimum(a, b).sum() / numpy.maximum(a, b).sum()
        self.assertGreater(both, 0.97)

    def test_the_same_command_gives_the_same_bytes(self):
        for method in ("zbuffer", "trace"):
            self.picture("--method", method, "--samples", "4", out="a.png")
            self.picture("--method", method, "--samples", "4", out="b.png")
            self.assertEqual(self.read("a.png"), self.read("b.png"))
        self.picture("--method", "trace", "--samples", "4", "--seed", "2", out="b.png")
        self.assertNotEqual(self.read("a.png"), self.read("b.png"))

    def test_depth_is_in_tenths_of_a_millimetre_and_nearest_at_the_nose(self):
        self.picture("--depth", "d.png", view="front")
        depth = read_png(self.read("d.png"))[:, :, 0].astype(int)
        seen = depth > 0
        self.assertTrue(0.3 < seen.mean() < 1.0)
        self.assertTrue(500 < (depth[seen].max() - depth[seen].min()) < 3000)  # 50 … 300 mm of head
        row, column = numpy.unravel_index(numpy.where(seen, depth, 10 ** 6).argmin(), depth.shape)
        self.assertLess(abs(column - 60), 25)
        self.assertTrue(30 < row < 100)

    def test_halves_have_their_own_colours(self):
        plain = self.picture("--frame-colour", "#101010").astype(int)
        upper = self.picture("--frame-colour", "#101010", "--upper-colour", "#e01010").astype(int)
        lower = self.picture("--frame-colour", "#101010", "--lower-colour", "#10e010").astype(int)
        rows_up = numpy.nonzero(abs(upper - plain).sum(axis=2) > 60)[0]
        rows_low = numpy.nonzero(abs(lower - plain).sum(axis=2) > 60)[0]
        self.assertGreater(len(rows_up), 20)
        self.assertGreater(len(rows_low), 20)
        self.assertLess(numpy.median(rows_up), numpy.median(rows_low))

    def test_a_transparent_background_has_alpha(self):
        rgba = self.picture("--background", "none")
        self.assertEqual(rgba.shape[2], 4)
        self.assertEqual(rgba[0, 0, 3], 0)
        self.assertEqual(rgba[60, 60, 3], 255)

    def test_every_material_texture_coating_and_light_draws(self):
        ground = ("--method", "trace", "--samples", "2", "--frame-colour", "#b08860")
        first = self.picture(*ground)
        for options in (("--frame-material", "translucent"), ("--upper-material", "brushed"), ("--lower-material", "metal"),
                        ("--upper-texture", "tortoiseshell"), ("--lower-texture", "pearl"), ("--lens-coating", "mirror"),
                        ("--lens-transmittance", "0.2", "--lens-lower-transmittance", "0.9"), ("--light", "shop"),
                        ("--light", "daylight"), ("--lips", "#b02030"), ("--dispersion",), ("--no-denoise",)):
            with self.subTest(options):
                self.assertGreater(abs(self.picture(*ground, *options).astype(int) - first).max(), 8)

    def test_a_prescription_shrinks_the_face_behind_it_in_both_methods(self):
        for method in ("zbuffer", "trace"):
            plano = self.picture("--method", method, "--samples", "8", size=240).astype(int)
            minus = self.picture("--method", method, "--samples", "8", size=240, worn="minus.json").astype(int)
            self.assertGreater((abs(plano - minus).sum(axis=2) > 24).mean(), 0.005)

    def test_maps_tapes_and_landmarks_report_their_range(self):
        for options, key in ((("--map", "curvature"), "rms"), (("--map", "clearance", "--worn", "worn.json"), "least"),
                             (("--map", "residual", "--scan", "head.mcap", "--unrolled"), "rms"), (("--map", "knowledge"), None),
                             (("--map", "difference", "--against", "head.json", "--range", "-1,1"), "rms"),
                             (("--map", "sigma", "--tapes", "girths", "--landmarks"), "mean")):
            with self.subTest(options):
                report = self.succeeds_json("render", "head.json", "--view", "left45", "--size", "200", "--out", "m.png", *options)
                picture = read_png(self.read("m.png"))
                self.assertGreater(len(numpy.unique(picture.reshape(-1, 3), axis=0)), 50)
                if key:
                    self.assertIn(key, report["pictures"][0]["numbers"])
        # A model does not differ from itself.
        report = self.succeeds_json("render", "head.json", "--view", "front", "--size", "200", "--out", "m.png", "--map",
                                    "difference", "--against", "head.json", "--range", "-1,1")
        self.assertEqual(report["pictures"][0]["numbers"]["rms"], 0)

    def test_two_frames_side_by_side(self):
        self.succeeds("render", "head.json", "--worn", "worn.json", "--beside-worn", "minus.json", "--view", "front", "--size",
                      "200", "--out", "two.png")
        picture = read_png(self.read("two.png"))
        self.assertGreater(picture.shape[1], 1.5 * picture.shape[0])

    def test_a_turntable_is_frames_and_an_animation(self):
        self.succeeds("render", "head.json", "--worn", "worn.json", "--view", "front", "--size", "80", "--turntable", "6", "--out",
                      "turn")
        names = [name for name in self.listing() if name.startswith("turn/")]
        self.assertEqual(sorted(names), [f"turn/frame_{k:03d}.png" for k in range(6)] + ["turn/turntable.webp"])
        first, half = read_png(self.read("turn/frame_000.png")), read_png(self.read("turn/frame_003.png"))
        self.assertEqual(first.shape, half.shape)
        data = self.read("turn/turntable.webp")
        self.assertEqual((data[:4], data[8:12], data.count(b"ANMF")), (b"RIFF", b"WEBP", 6))

    def test_the_view_from_inside_has_its_numbers(self):
        report = self.succeeds_json("render", "head.json", "--worn", "minus.json", "--inside", "both", "--gaze", "0,0;20,-10",
                                    "--size", "160", "--out", "inside.png")
        right = report["pictures"][0]["numbers"]["right"]["gaze"][0]
        self.assertLess(abs(right["mean_error_d"]), 0.02)
        self.assertLess(right["magnification_percent"], 0.0)
        self.succeeds("render", "head.json", "--worn", "minus.json", "--inside", "right", "--inside-map", "--out", "map.png")
        self.assertGreater(len(numpy.unique(read_png(self.read("map.png")).reshape(-1, 3), axis=0)), 100)

    def test_a_progressive_picture_ends_as_the_picture(self):
        self.picture("--method", "trace", "--samples", "4", "--progressive", "p_now.png")
        self.assertEqual(self.read("p_now.png"), self.read("p.png"))

    def test_make_up_lies_on_the_face_that_wears_it_whatever_was_drawn_before(self):
        # The same head with its eyes said to be 6 mm higher: lips and brows move with them.
        moved = json.loads(self.read("worn.json"))
        for eye in ("eye_right", "eye_left"):
            moved["face_points"][eye]["position_mm"][2] += 6
        self.write("moved.json", json.dumps(moved))
        look = {"lips": "#b02030@1", "brows": "#201008@1", "model": "head.json", "view": "front", "size": 120}
        self.write("batch.json", json.dumps({"pictures": [dict(look, worn="worn.json", out="a.png"),
                                                          dict(look, worn="moved.json", out="b.png")]}))
        self.succeeds("render", "--batch", "batch.json")
        self.picture("--lips", "#b02030@1", "--brows", "#201008@1", worn="moved.json")
        self.assertEqual(self.read("p.png"), self.read("b.png"))
        self.assertNotEqual(self.read("a.png"), self.read("b.png"))

    def test_a_batch_draws_what_the_single_commands_draw(self):
        batch = {"defaults": {"model": "head.json", "worn": "worn.json", "size": 100},
                 "pictures": [{"view": "front", "out": "front.png", "caption": "front"},
                              {"view": "left45", "out": "left.png", "frame_colour": "#802020", "worn": "minus.json"},
                              {"view": "right45", "method": "trace", "samples": 2, "no_denoise": True}],
                 "sheet": {"out": "sheet.png", "columns": 2, "title": "three"}}
        self.write("batch.json", json.dumps(batch))
        report = self.succeeds_json("render", "--batch", "batch.json")
        self.assertEqual([p["view"] for p in report["pictures"]], ["front", "left45", "right45"])
        self.picture(size=100)
        self.assertEqual(self.read("p.png"), self.read("front.png"))
        self.picture("--frame-colour", "#802020", size=100, worn="minus.json", view="left45")
        self.assertEqual(self.read("p.png"), self.read("left.png"))
        sheet = read_png(self.read("sheet.png"))
        self.assertGreaterEqual(sheet.shape[0], 200)
        self.assertGreaterEqual(sheet.shape[1], 200)

    def test_what_is_wrong_is_said_and_nothing_is_written(self):
        picture = ("render", "head.json", "--view", "front", "--out", "p.png")
        for arguments, naming in ((picture + ("--background", "environment"), ("trace",)),
                                  (picture + ("--frame-colour", "#12345"), ("#12345",)),
                                  (picture + ("--depth", "d.jpg"), ("d.jpg",)),
                                  (picture + ("--map", "curvature", "--range", "2,1"), ("2,1",)),
                                  (picture + ("--map", "curvature", "--depth", "d.png"), ("depth",)),
                                  (picture + ("--inside", "both"), ("--worn",)),
                                  (("render", "head.json", "--view", "front"), ("--out",)),
                                  (("render", "head.json", "--out", "p.png"), ("--view",)),
                                  (("render", "--view", "front", "--out", "p.png"), ("model",))):
            with self.subTest(arguments):
                self.fails(*arguments, naming=naming, status=2)
        for batch, naming in (("{", ("JSON",)), ('{"pictures": []}', ("pictures",)),
                              ('{"pictures": [{"view": "front"}]}', ("pictures[0]",)),
                              ('{"pictures": [{"model": "head.json", "view": "front", "out": "a.png", "colour": 1}]}', ("pictures[0]", "colour")),
                              ('{"pictures": [{"model": "head.json", "view": "front", "out": "a.png", "size": "big"}]}', ("pictures[0]", "size")),
                              ('{"pictures": [{"model": "head.json", "view": "front", "out": "a.png", "size": [1]}]}', ("pictures[0].size",))):
            with self.subTest(batch):
                self.write("batch.json", batch)
                self.fails("render", "--batch", "batch.json", naming=naming + ("batch.json",))


if __name__ == "__main__":
    annulus_cli.main()
