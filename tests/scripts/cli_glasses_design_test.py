#!/usr/bin/python3
"""glasses design: the library, sizes in the boxing system, every field, words, adjusting, own libraries, pictures."""

import json
import math
import os

import annulus_cli
from annulus_cli import ProgramTest
from cli_chain_test import png_rows

EXAMPLES = ("example1", "example2", "example3", "example4")
OPTICIANS = ("round", "panto", "boston", "wellington", "browline", "aviator", "navigator", "square", "rectangle", "oval", "cat-eye",
             "butterfly", "octagon", "hexagon", "p3", "keyhole-round", "half-rim-rectangle", "rimless-oval", "rimless-rectangle",
             "half-eye", "oversize", "sport-wrap", "children-round")
OWN = {"format": "annulus-frame-library", "version": 1, "styles": [
    {"name": "mine", "description": "of my own", "material": "metal",
     "parameters": {"width_mm": 50, "upper_outer_mm": 8, "upper_inner_mm": 8, "upper_thickness_mm": 2.5, "lower_outer_mm": 8,
                    "lower_inner_mm": 8, "lower_thickness_mm": 2.5, "height_mm": 40, "bridge_height_mm": 24},
     "details": {"bridge": "keyhole", "face_form_deg": 5},
     "sizes": [{"name": "only", "a_mm": 47, "b_mm": 38, "dbl_mm": 19, "temple_mm": 142}]}]}


class Design(ProgramTest):
    def design(self, *options):
        return self.succeeds_json("glasses", "design", *options)

    def notes(self, *options):
        """The report and the notes on stderr of a design that was adjusted."""
        done = self.run_program("glasses", "design", *options, "--json", "-")
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = done.stderr.splitlines()
        for line in lines:
            self.assertTrue(line.startswith("annulus: adjusted: "), line)
        return json.loads(done.stdout), lines

    def test_the_library_is_printed_as_a_table_and_as_json(self):
        text = self.succeeds("glasses", "design", "--list")
        library = self.succeeds_json("glasses", "design", "--list")
        self.assertEqual(library["format"], "annulus-frame-library")
        names = [style["name"] for style in library["styles"]]
        self.assertEqual(len(text.splitlines()), 1 + len(names))
        self.assertLessEqual(set(EXAMPLES + OPTICIANS), set(names))
        self.assertGreaterEqual(len(names) - len(EXAMPLES), 24)
        for style in library["styles"]:
            self.assertIn(style["name"], text)
            self.assertIn(style["description"], text)
            self.assertEqual(len(style.get("sizes", [])), 0 if style["name"] in EXAMPLES else 3)

    def test_every_style_in_every_size_has_the_box_it_is_sold_with(self):
        library = self.succeeds_json("glasses", "design", "--list")
        for style in library["styles"]:
            for size in style.get("sizes", []):
                report = self.design("--style", style["name"], "--size", size["name"])
                boxing = report["boxing"]
                self.assertAlmostEqual(boxing["a_mm"], size["a_mm"], delta=1e-6)
                self.assertAlmostEqual(boxing["dbl_mm"], size["dbl_mm"], delta=1e-6)
                self.assertAlmostEqual(boxing["temple_mm"], size["temple_mm"], delta=1e-6)
                self.assertEqual(report["size"], f"{size['a_mm']:.0f}□{size['dbl_mm']:.0f}-{size['temple_mm']:.0f}")
                self.assertEqual(report["adjusted"], [])
                self.assertGreater(boxing["ed_mm"], max(boxing["a_mm"], boxing["b_mm"]) - 1e-9)
                self.assertLess(boxing["ed_mm"], math.hypot(boxing["a_mm"], boxing["b_mm"]) + 1e-9)

    def test_the_paper_s_examples_keep_the_paper_s_proportions(self):
        for name, aspect, d1_over_d2 in (("example1", 1.0, 1), ("example2", 1.0, 1), ("example3", 0.7, 1), ("example4", 0.8, 3)):
            fields = self.design("--style", name)["fields"]
            self.assertAlmostEqual(fields["height_mm"] / fields["width_mm"], aspect)
            self.assertAlmostEqual(fields["upper_thickness_mm"] / fields["lower_thickness_mm"], d1_over_d2)
            self.assertIsNone(fields["depth_mm"])
            self.assertEqual(fields["bridge"], "straight")

    def test_the_paper_s_words_come_back(self):
        words = self.design("--style", "example4")["words"]
        self.assertEqual({k: words[k] for k in ("upper-outer", "upper-inner", "lower-inner", "lower-outer")},
                         {"upper-outer": "middle", "upper-inner": "middle", "lower-inner": "slightly round",
                          "lower-outer": "extremely round"})
        report = self.design("--style", "example1", "--upper-outer", "slightly-round", "--upper-thickness", "quite thin")
        self.assertEqual(report["words"]["upper-outer"], "slightly round")
        self.assertAlmostEqual(report["fields"]["upper_outer_mm"], 0.20 * 50)
        self.assertEqual(report["words"]["upper-thickness"], "quite thin")

    def test_every_field_is_an_option_and_lands_in_the_file(self):
        options = {"rim": "half", "bridge": "saddle", "pads": "adjustable", "temple": "skull", "hinge": "barrel"}
        numbers = {"width": 52, "height": 41, "upper-outer": 6, "upper-inner": 7, "upper-thickness": 3.1, "lower-outer": 8,
                   "lower-inner": 9, "lower-thickness": 2.9, "bridge-height": 25, "bridge-gap": 17, "depth": 4.2, "arm-height": 27,
                   "arm-width": 5, "groove-depth": 0.8, "groove-width": 1.4, "frame-curve": 4, "face-form": 5, "end-piece": 6,
                   "tip-length": 38, "tip-drop": 40, "pad-length": 12, "pad-width": 6, "bridge-forward": 3, "bridge-rise": -1,
                   "lens-edge": 2.5}
        arguments = [a for k, v in {**options, **numbers}.items() for a in ("--" + k, v)]
        report = self.design("--style", "example3", *arguments, "--out", "f.json")
        self.assertEqual(report["adjusted"], [])
        written = self.read_json("f.json")
        self.assertEqual(written["version"], 2)
        flat = {**written["parameters"], **written["details"]}
        for name, value in numbers.items():
            key = next(k for k in flat if k.rsplit("_", 1)[0] == name.replace("-", "_"))
            self.assertEqual(flat[key], value, key)
            self.assertEqual(report["fields"][key], value, key)
        for name, word in options.items():
            self.assertEqual(flat[name], word)
        # The help names each with what it takes.
        text = self.succeeds("glasses", "design", "--help")
        for name in (*options, *numbers):
            self.assertIn(f"--{name} ", text)
        self.assertIn("straight|saddle|keyhole", text)

    def test_a_size_in_numbers(self):
        for text in ("50-18-145", "50□18-145", "50x18-145"):
            boxing = self.design("--style", "wellington", "--size", text)["boxing"]
            self.assertAlmostEqual(boxing["a_mm"], 50, delta=1e-6)
            self.assertAlmostEqual(boxing["dbl_mm"], 18, delta=1e-6)
            self.assertAlmostEqual(boxing["temple_mm"], 145, delta=1e-6)

    def test_the_file_holds_the_temples_of_its_size(self):
        self.succeeds("glasses", "design", "--style", "boston", "--size", "medium", "--out", "f.json")
        ear = self.read_json("f.json")["adjustment"]["temple_right"]["ear_mm"]
        left = self.read_json("f.json")["adjustment"]["temple_left"]["ear_mm"]
        self.assertEqual([-left[0], *left[1:]], ear)
        self.assertTrue(-145 < ear[1] < -80, ear)  # the bend lies before the tip of a 145 mm temple
        self.assertIn("style: boston", self.succeeds("inspect", "f.json"))

    def test_extreme_values_are_adjusted_with_a_message_and_never_broken(self):
        for options in (("--upper-outer", "40"), ("--height", "300"), ("--bridge-height", "0.1"), ("--upper-thickness", "90%"),
                        ("--rim", "rimless", "--bridge", "keyhole"), ("--groove-depth", "5", "--groove-width", "9"),
                        ("--face-form", "80"), ("--frame-curve", "60"), ("--bridge-gap", "0.5"), ("--width", "5")):
            with self.subTest(options):
                report, notes = self.notes("--style", "boston", *options)
                self.assertGreaterEqual(len(notes), 1)
                self.assertEqual([n.removeprefix("annulus: adjusted: ") for n in notes], report["adjusted"])
                self.assertIn("bridge" if options[0] == "--rim" else options[0][2:], " ".join(notes))

    def test_what_was_adjusted_can_be_read_and_is_not_adjusted_again(self):
        self.run_program("glasses", "design", "--style", "aviator", "--lower-inner", "60", "--out", "f.json")
        self.succeeds("inspect", "f.json")

    def test_what_cannot_be_understood_is_wrong_usage_and_named(self):
        for options, naming in ((("--style", "baroque"), ("baroque", "boston")), (("--bridge", "arch"), ("arch", "keyhole")),
                                (("--height", "tall"), ("height", "tall")), (("--face-form", "5%"), ("face-form",)),
                                (("--size", "huge"), ("huge", "medium")), (("--size", "50-18"), ("50-18",)),
                                (("--size", "500-18-145"), ("a_mm",)), (("--width", "-3"), ("width",)),
                                (("--size", "50-18-145", "--width", "60"), ("width",)), (("--upper-outer", "nan"), ("upper-outer",))):
            with self.subTest(options):
                self.fails("glasses", "design", *options, "--out", "f.json", naming=naming, status=2)

    def test_asking_for_nothing_is_wrong_usage(self):
        self.fails("glasses", "design", naming=("--out",), status=2)

    def test_a_picture_shows_both_rims(self):
        self.succeeds("glasses", "design", "--style", "panto", "--size", "small", "--picture", "p.png", "--picture-width", "240")
        width, height, pixels = png_rows(self.read("p.png"))
        self.assertEqual(width, 240)
        self.assertTrue(60 < height < 160, height)
        self.assertGreater(len(set(pixels)), 20)

    def test_the_same_design_gives_the_same_bytes(self):
        for name in ("a", "b"):
            self.succeeds("glasses", "design", "--style", "p3", "--size", "large", "--face-form", "7.3", "--out", name + ".json",
                          "--picture", name + ".png", "--picture-width", "120")
        self.assertEqual(self.read("a.json"), self.read("b.json"))
        self.assertEqual(self.read("a.png"), self.read("b.png"))

    def test_an_own_library_stands_beside_the_built_in_one(self):
        self.write("own.json", json.dumps(OWN))
        before = self.listing()
        report = self.design("--library", "own.json", "--style", "mine", "--size", "only")
        self.assertEqual(report["size"], "47□19-142")
        self.assertAlmostEqual(report["boxing"]["b_mm"], 38, delta=1e-6)
        self.assertEqual(report["fields"]["bridge"], "keyhole")
        self.assertEqual(report["fields"]["face_form_deg"], 5)
        self.assertIn("mine", self.succeeds("glasses", "design", "--library", "own.json", "--list"))
        self.design("--library", "own.json", "--style", "boston")
        self.assertEqual(self.listing(), before)

    def test_the_printed_library_can_be_used_as_one(self):
        self.succeeds("glasses", "design", "--list", "--json", "all.json")
        self.assertEqual(self.succeeds("glasses", "design", "--library", "all.json", "--list"),
                         self.succeeds("glasses", "design", "--list"))

    def test_an_own_library_that_is_wrong_names_line_or_key(self):
        good = json.dumps(OWN, indent=1)
        for wrong, naming in ((good.replace('"height_mm": 40', '"height_mm": "tall"'), ("mine", "parameters.height_mm")),
                              (good.replace('"bridge":', '"bridges":'), ("mine", "details.bridges")),
                              (good.replace('"keyhole"', '"arch"'), ("arch", "keyhole")),
                              (good.replace('"a_mm": 47', '"a_mm": 4.7'), ("sizes[0]", "a_mm")),
                              (good.replace('"material": "metal",', '"material" "metal",'), ("line 8",)),
                              (good[:-40], ("line ",)), ("", ("own.json",)), (good.replace("-library", "s"), ("format",))):
            with self.subTest(naming):
                self.assertNotEqual(wrong, good)
                self.write("own.json", wrong)
                self.fails("glasses", "design", "--library", "own.json", "--list", naming=("own.json", *naming))

    def test_files_of_version_1_are_still_read(self):
        corpus = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "fuzz", "corpus")
        for kind, name in (("frame_json", "frame"), ("worn_json", "worn frame")):
            with open(os.path.join(corpus, kind, "version1"), encoding="utf-8") as f:
                self.write("v1.json", f.read())
            self.assertIn(f"kind: {name}", self.succeeds("inspect", "v1.json"))


if __name__ == "__main__":
    annulus_cli.main()
