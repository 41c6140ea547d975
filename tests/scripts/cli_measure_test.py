#!/usr/bin/python3
"""measure and its neighbours on a simulated person: scan → fit → table, files, landmarks by hand, comparison, refusals."""

import csv
import io
import json
import math
import unittest

import annulus_cli
import vase_scan
from annulus_cli import ProgramTest

NORMAL_975 = 1.959963984540054  # scipy.stats.norm.ppf(0.975)
UNITS = ("mm", "mm2", "mm3", "deg")
FIXED_KEYS = {"id", "term", "definition", "measured_share", "iso20685_limit_mm", "iso20685_ok", "landmarks"}


def unit_of(measurement):
    """The unit that the keys of a measurement name; all four numbers must name the same."""
    units = [unit for unit in UNITS if f"value_{unit}" in measurement]
    assert len(units) == 1, measurement
    for number in ("sigma", "low95", "high95", "sigma_parts"):
        assert f"{number}_{units[0]}" in measurement, measurement
    return units[0]


class SimulatedPerson(ProgramTest):
    """Models of one scan of the whole person and one of the head, made once for all tests."""

    models = {}

    @classmethod
    def setUpClass(cls):
        if not cls.models:
            case = cls("runTest")
            case.setUp()
            unittest.addModuleCleanup(case.doCleanups)
            for name in ("body", "head"):
                case.succeeds("scan", "--profile", name, "--out", f"{name}.mcap")
                case.succeeds("fit", f"{name}.mcap", "--out", f"{name}.json")
                cls.models[name] = case.path(f"{name}.json")
            case.succeeds("fit", "body.mcap", "--no-covariance", "--out", "bare.json")
            cls.models["bare"] = case.path("bare.json")
        cls.body = cls.models["body"]

    def runTest(self):
        """Only gives setUpClass a test case."""

    def table(self, model=None, *options):
        report = self.succeeds_json("measure", model or self.body, *options)
        return report, {m["id"]: m for m in report["measurements"]}


class Table(SimulatedPerson):
    def test_a_whole_person_has_at_least_forty_measurements_with_the_keys_of_the_design(self):
        report, table = self.table()
        self.assertGreaterEqual(len(report["measurements"]), 40)
        self.assertEqual(len(table), len(report["measurements"]), "an id stands for one measurement")
        landmarks = {landmark["id"] for landmark in report["landmarks"]}
        for m in table.values():
            with self.subTest(m["id"]):
                unit_of(m)
                self.assertLessEqual(FIXED_KEYS, set(m))
                self.assertTrue(m["term"] and m["definition"] and m["method"])
                self.assertTrue(0.0 <= m["measured_share"] <= 1.0)
                self.assertLessEqual(set(m["landmarks"]), landmarks)
                self.assertIn(m["iso20685_limit_mm"], (None, 1, 2, 4, 5, 9))

    def test_sigma_is_the_root_of_its_parts_and_the_interval_is_1_96_of_it(self):
        for name, m in self.table()[1].items():
            with self.subTest(name):
                unit = unit_of(m)
                value, sigma = m[f"value_{unit}"], m[f"sigma_{unit}"]
                parts = m[f"sigma_parts_{unit}"]
                self.assertEqual(set(parts), {"fit", "landmarks", "detail", "calibration", "sway"})
                self.assertGreater(sigma, 0.0)
                self.assertAlmostEqual(sigma, math.sqrt(sum(p * p for p in parts.values())), delta=1e-9 * sigma)
                self.assertAlmostEqual(m[f"low95_{unit}"], value - NORMAL_975 * sigma, delta=1e-9 * abs(value))
                self.assertAlmostEqual(m[f"high95_{unit}"], value + NORMAL_975 * sigma, delta=1e-9 * abs(value))
                within = None if m["iso20685_limit_mm"] is None else NORMAL_975 * sigma <= m["iso20685_limit_mm"]
                self.assertEqual(m["iso20685_ok"], within)

    def test_what_no_sigma_holds_is_said(self):
        report, _ = self.table()
        self.assertEqual(report["errors_left_out"], ["calibration", "sway"])  # nobody told this model of either
        text = self.succeeds("measure", self.body)
        self.assertEqual(text.count("not in ±"), 2)

    def test_a_girth_is_the_tape_of_the_section_at_its_level(self):
        report, table = self.table()
        heights = {level["id"]: level["z_mm"] for level in report["levels"]}
        for level in ("neck", "chest", "waist", "hip"):
            section = self.succeeds_json("section", self.body, "--z", heights[f"level.{level}"])
            self.assertAlmostEqual(table[f"{level}_girth"]["value_mm"], section["tape_mm"], delta=1e-6)
        slab = self.succeeds_json("slab", self.body, "--z-min", heights["level.hip"], "--z-max", heights["level.waist"])
        volume = table["waist_to_hip_volume"]["value_mm3"]
        self.assertAlmostEqual(volume, slab["volume_mm3"], delta=1e-6 * volume)
        self.assertGreater(table["waist_to_hip_volume"]["sigma_mm3"], slab["volume_sigma_mm3"])  # its levels are found

    def test_what_is_placed_by_proportion_carries_a_note(self):
        report, table = self.table()
        source = {landmark["id"]: landmark for landmark in report["landmarks"]}
        self.assertIn("proportion", {landmark["source"] for landmark in source.values()})
        for m in table.values():
            guessed = [source[i]["term"] for i in m["landmarks"] if source[i]["source"] == "proportion"]
            self.assertEqual("by proportion" in m["note"], bool(guessed), m)
            for term in guessed:
                self.assertIn(term, m["note"])

    def test_the_text_has_a_row_for_each_in_columns(self):
        text = self.succeeds("measure", self.body)
        self.assertNotIn("conform", text)
        self.assertNotIn("mm3", text)
        places = set()
        for m in self.table()[1].values():
            row = next(line for line in text.splitlines() if line.startswith(m["term"] + "  "))
            places.add(row.index(" %"))
            if unit_of(m) == "mm":
                self.assertIn(f" {m['value_mm']:.1f} mm ", row)
        self.assertEqual(len(places), 1, "one column")

    def test_a_head_alone_has_its_own_measurements_and_says_what_is_missing(self):
        report, table = self.table(self.models["head"])
        for name in ("head_girth", "head_length", "head_breadth", "nose_length", "pupil_distance", "temple_to_ear_left"):
            self.assertIn(name, table)
        for name in ("waist_girth", "hip_girth"):
            self.assertNotIn(name, table)
        self.assertTrue([sentence for sentence in report["omitted"] if "waist" in sentence])

    def test_a_scan_that_counts_z_from_elsewhere_has_lengths_and_no_heights(self):
        rows = vase_scan.csv().splitlines()
        moved = [line.split(",") for line in rows[2:]]
        lines = rows[:2] + [",".join([row[0], str(float(row[1]) - 1000), *row[2:]]) for row in moved]
        self.write("vase.csv", "\n".join(lines) + "\n")
        self.succeeds("import", "vase.csv", "--out", "vase.mcap")
        self.succeeds("fit", "vase.mcap", "--out", "vase.json")
        report, table = self.table("vase.json")
        self.assertAlmostEqual(table["waist_girth"]["value_mm"], vase_scan.girth("waist"), delta=1.0)
        drop = vase_scan.LEVELS["waist"][0] - vase_scan.LEVELS["hip"][0]
        self.assertAlmostEqual(table["waist_to_hip_drop"]["value_mm"], drop, delta=5.0)
        self.assertEqual([name for name in table if name.endswith("_height")], [])
        self.assertTrue([sentence for sentence in report["omitted"] if sentence.startswith("Heights above the floor: ")])

    def test_without_covariance_values_stay_and_uncertainties_are_not_known(self):
        _, full = self.table()
        _, bare = self.table(self.models["bare"])
        self.assertEqual(set(bare), set(full))
        for name, m in bare.items():
            unit = unit_of(m)
            self.assertAlmostEqual(m[f"value_{unit}"], full[name][f"value_{unit}"], delta=2e-3 * abs(full[name][f"value_{unit}"]) + 1)
            for key in (f"sigma_{unit}", f"low95_{unit}", f"high95_{unit}", "iso20685_ok"):
                self.assertIsNone(m[key])
        model = self.models["bare"]
        for command in (("measure", model), ("section", model, "--z", "1100"),
                        ("slab", model, "--z-min", "1050", "--z-max", "1100"),
                        ("distance", model, "--from", "60,1100", "--to", "120,1100", "--method", "tape"),
                        ("region", model, "--a", "0,1080", "--b", "180,1080", "--c", "90,1130", "--d", "90,1030")):
            text = self.succeeds(*command)
            self.assertIn("± not known", text, command)
            self.assertNotIn("nan", text, command)


class Files(SimulatedPerson):
    def test_the_csv_holds_the_numbers_of_the_json_each_in_its_unit(self):
        self.succeeds("measure", self.body, "--out", "t.csv", "--out", "t.json")
        rows = list(csv.DictReader(io.StringIO(self.read("t.csv").decode())))
        table = self.read_json("t.json")["measurements"]
        self.assertEqual([row["id"] for row in rows], [m["id"] for m in table])
        for row, m in zip(rows, table):
            unit = unit_of(m)
            self.assertNotIn(None, row, "more fields than columns")
            self.assertEqual((row["term"], row["unit"], row["method"]), (m["term"], unit, m["method"]))
            for number in ("value", "sigma", "low95", "high95"):
                self.assertAlmostEqual(float(row[number]), m[f"{number}_{unit}"], delta=5.1e-5)
            self.assertEqual(row["landmarks"].split(), m["landmarks"])
            self.assertEqual(row["iso20685_ok"], {True: "true", False: "false", None: ""}[m["iso20685_ok"]])
            self.assertEqual(row["note"], m["note"])

    def test_every_format_is_written_the_same_each_time_and_the_model_stays_as_it_was(self):
        names = ("t.json", "t.csv", "t.smis", "t.vit", "t.freesewing.json", "t.pdf")
        options = [option for name in names for option in ("--out", name)]
        with open(self.body, "rb") as f:
            model = f.read()
        self.succeeds("measure", self.body, *options, "--units", "inch", "--language", "ja")
        first = {name: self.read(name) for name in names}
        self.succeeds("measure", self.body, *options, "--units", "inch", "--language", "ja")
        self.assertEqual({name: self.read(name) for name in names}, first)
        self.assertEqual(set(self.listing()), set(names))
        with open(self.body, "rb") as f:
            self.assertEqual(f.read(), model)
        self.assertEqual(json.loads(first["t.json"]), self.table()[0], "files are in mm whatever the sheet's unit")

    def test_what_a_format_leaves_out_is_said_once_for_each_reason(self):
        lines = self.succeeds("measure", self.body, "--out", "t.smis").splitlines()
        reasons = [line.split(": ", 1)[1] for line in lines]
        self.assertEqual(len(set(reasons)), len(reasons))
        self.assertEqual(len([line for line in lines if line.endswith("not a length") and "head_volume" in line]), 1)


class ByHand(SimulatedPerson):
    WAIST = 1060.0

    def test_a_waist_set_by_hand_moves_the_waist_and_nothing_else(self):
        self.succeeds("landmarks", self.body, "--set", f"level.waist={self.WAIST}", "--out", "marks.json")
        _, found = self.table()
        report, given = self.table(self.body, "--landmarks", "marks.json")
        section = self.succeeds_json("section", self.body, "--z", self.WAIST)
        self.assertAlmostEqual(given["waist_girth"]["value_mm"], section["tape_mm"], delta=1e-6)
        self.assertNotAlmostEqual(given["waist_girth"]["value_mm"], found["waist_girth"]["value_mm"], delta=0.5)
        height = given["waist_height"]
        self.assertEqual(height["value_mm"], self.WAIST)
        self.assertEqual(height["sigma_parts_mm"], {"fit": 0, "landmarks": 2, "detail": 0, "calibration": 0, "sway": 0})
        waist = next(landmark for landmark in report["landmarks"] if landmark["id"] == "level.waist")
        self.assertEqual((waist["source"], waist["z_mm"]), ("given", self.WAIST))
        for name, m in given.items():
            self.assertEqual("set by hand: " + waist["term"] in m["note"], "level.waist" in m["landmarks"], name)
            if "level.waist" not in m["landmarks"]:
                self.assertEqual(m, found[name])

    def test_a_file_of_other_landmarks_or_another_body_is_refused(self):
        self.succeeds("landmarks", self.body, "--set", f"level.waist={self.WAIST}", "--out", "marks.json")
        good = self.read_json("marks.json")
        self.fails("measure", self.models["head"], "--landmarks", "marks.json", naming=("marks.json", "level.waist", "1060"))
        self.write("bad.json", json.dumps({**good, "given": [{**good["given"][0], "id": "level.waste"}]}))
        self.fails("measure", self.body, "--landmarks", "bad.json", naming=("bad.json", "level.waste", "level.waist"))
        for content in ("", "{", "[]", "{}", json.dumps({**good, "version": 99}), json.dumps({**good, "given": 3})):
            with self.subTest(content[:40]):
                self.write("bad.json", content)
                self.fails("measure", self.body, "--landmarks", "bad.json", "--out", "t.csv", naming=("bad.json",))


class Comparison(SimulatedPerson):
    def test_a_scan_compared_with_itself_differs_nowhere(self):
        report = self.succeeds_json("compare", self.body, self.body)
        self.assertEqual(len(report["differences"]), len(self.table()[1]))
        self.assertEqual(report["not_comparable"], [])
        for d in report["differences"]:
            unit = next(unit for unit in UNITS if f"a_{unit}" in d)
            self.assertEqual(d[f"difference_{unit}"], 0)
            self.assertFalse(d["significant"])
        self.assertNotIn("  yes", self.succeeds("compare", self.body, self.body))

    def test_without_covariance_nothing_is_significant(self):
        report = self.succeeds_json("compare", self.models["bare"], self.body)
        self.assertEqual(report["tested"], 0)
        self.assertEqual({d["significant"] for d in report["differences"]}, {None})

    def test_what_only_one_scan_has_is_named(self):
        report = self.succeeds_json("compare", self.body, self.models["head"])
        self.assertTrue([sentence for sentence in report["not_comparable"] if sentence.startswith("waist_girth: ")])
        self.assertIn("measured in A only: ", self.succeeds("compare", self.body, self.models["head"]))


class Refusals(SimulatedPerson):
    def test_a_task_that_fails_ends_with_1_and_leaves_nothing(self):
        self.write("no.json", "{}")
        for arguments, naming in (
                (("measure", "missing.json"), ("missing.json",)),
                (("measure", "no.json", "--out", "t.csv"), ("no.json", "MODEL.json")),
                (("measure", self.body, "--landmarks", "missing.json"), ("missing.json",)),
                (("measure", self.body, "--out", "nowhere/t.csv"), ("nowhere/t.csv",)),
                (("measure", self.body, "--out", "nowhere/t.pdf"), ("nowhere/t.pdf",)),
                (("landmarks", self.body, "--set", "level.waist=9999"), ("9999",)),
                (("region", self.body, "--a", "0,1080", "--b", "180,1080", "--c", "90,1080", "--d", "90,1080"), ("C and D",)),
                (("distance", self.body, "--from", "90,9999", "--to", "90,1100", "--method", "tape"), ("9999",)),
                (("section", self.body, "--z", "9999"), ("9999",)),
                (("compare", self.body, "no.json"), ("no.json",))):
            with self.subTest(arguments):
                self.fails(*arguments, naming=naming)

    def test_wrong_usage_ends_with_2_before_anything_is_written(self):
        for arguments, naming in (
                (("measure",), ("model",)),
                (("measure", self.body, "--out", "t.csv", "--out", "t.xls"), ("t.xls", ".csv")),
                (("measure", self.body, "--out", "t.pdf", "--units", "ell"), ("ell", "inch")),
                (("measure", self.body, "--out", "t.pdf", "--language", "xx"), ("xx", "ja")),
                (("distance", self.body, "--from", "90", "--to", "90,1100", "--method", "tape"), ("--from",)),
                (("distance", self.body, "--from", "90,1000", "--to", "90,1100", "--method", "laser"), ("laser",)),
                (("compare", self.body), ("model_b",))):
            with self.subTest(arguments):
                line = self.fails(*arguments, naming=naming, status=2)
                self.assertNotIn("->", line, "the message shows the program's inside")

    def test_a_place_that_no_sensor_saw_is_no_end_of_a_distance(self):
        places = [(theta, z) for z in range(1200, 1400, 10) for theta in range(0, 360, 4)]
        self.write("places.csv", "theta_deg,z_mm\n" + "".join(f"{theta},{z}\n" for theta, z in places))
        self.succeeds("eval", self.body, "--points", "places.csv", "--out", "seen.csv")
        seen = csv.DictReader(io.StringIO(self.read("seen.csv").decode()))
        unseen = [f"{row['theta_deg']},{row['z_mm']}" for row in seen if row["measured"] == "unknown"]
        self.assertTrue(unseen, "the arms hide nothing")
        for method, more in (("tape", ()), ("geodesic", ()), ("plane", ("--via", "90,1250")), ("view", ("--view", "90,0"))):
            with self.subTest(method):
                self.fails("distance", self.body, "--from", unseen[0], "--to", "90,1200", "--method", method, *more,
                           naming=("not seen",))


if __name__ == "__main__":
    annulus_cli.main()
