#!/usr/bin/python3
"""annulus compare: two scans of one body, and of a body that grew by a known share."""

import json

import annulus_cli
import vase_scan
from annulus_cli import ProgramTest

GROWTH = 1.01


class Compare(ProgramTest):
    """A and again: one body, other noise. grown: the body 1 % wider."""

    @classmethod
    def setUpClass(cls):
        case = cls("runTest")
        case.setUp()
        cls.addClassCleanup(case.doCleanups)
        cls.models = {}
        for name, options in (("a", {"seed": 1}), ("again", {"seed": 2}), ("grown", {"seed": 3, "stretch": GROWTH})):
            case.write(f"{name}.csv", vase_scan.csv(**options))
            case.succeeds("import", f"{name}.csv", "--out", f"{name}.mcap")
            case.succeeds("fit", f"{name}.mcap", "--out", f"{name}.json")
            cls.models[name] = case.path(f"{name}.json")

    def runTest(self):
        """Only gives setUpClass a test case."""

    def compared(self, a, b):
        report = self.succeeds_json("compare", self.models[a], self.models[b])
        return report, {d["id"]: d for d in report["differences"]}

    def test_a_body_that_grew_has_significant_differences_of_the_right_size(self):
        _, differences = self.compared("a", "grown")
        for level in ("chest", "waist", "hip"):
            d = differences[f"{level}_girth"]
            true = (GROWTH - 1) * vase_scan.girth(level)
            self.assertTrue(d["significant"], d)
            self.assertAlmostEqual(d["difference_mm"], true, delta=1.0)
            self.assertAlmostEqual(d["difference_mm"], d["b_mm"] - d["a_mm"], delta=1e-9)
            self.assertAlmostEqual(d["z"], d["difference_mm"] / d["sigma_mm"], delta=1e-6)
            self.assertTrue(d["low95_mm"] < d["difference_mm"] < d["high95_mm"])

    def test_the_sd_of_a_difference_is_the_root_of_both_scans_squares(self):
        _, differences = self.compared("a", "again")
        tables = [{m["id"]: m for m in self.succeeds_json("measure", self.models[name])["measurements"]}
                  for name in ("a", "again")]
        girth = "waist_girth"
        expected = sum(table[girth]["sigma_mm"] ** 2 for table in tables) ** 0.5
        self.assertAlmostEqual(differences[girth]["sigma_mm"], expected, delta=1e-3 * expected)

    def test_the_correction_only_raises_p(self):
        report, differences = self.compared("a", "again")
        tested = [d for d in differences.values() if d["p"] is not None]
        self.assertEqual(report["tested"], len(tested))
        for d in tested:
            self.assertGreaterEqual(d["p_holm"], d["p"])
            self.assertEqual(d["significant"], d["p_holm"] < 0.05)

    def test_turning_the_comparison_around_turns_the_signs(self):
        _, there = self.compared("a", "grown")
        _, back = self.compared("grown", "a")
        for name, d in there.items():
            self.assertEqual(back[name]["p"], d["p"], name)
        self.assertEqual(back["waist_girth"]["difference_mm"], -there["waist_girth"]["difference_mm"])

    def test_a_scan_compared_with_itself_differs_nowhere(self):
        report, differences = self.compared("a", "a")
        self.assertEqual(report["not_comparable"], [])
        for d in differences.values():
            self.assertEqual(next(v for k, v in d.items() if k.startswith("difference")), 0)
            self.assertFalse(d["significant"])

    def test_the_text_says_what_was_assumed_of_the_ring(self):
        text = self.succeeds("compare", self.models["a"], self.models["grown"])
        self.assertIn("B - A", text)
        self.assertIn("errors of the ring", text)
        report, _ = self.compared("a", "grown")
        self.assertIn(report["ring_errors"], ("common", "independent"))

    def test_the_report_goes_to_a_file_too(self):
        self.succeeds("compare", self.models["a"], self.models["again"], "--json", "report.json")
        self.assertEqual(self.read_json("report.json"),
                         json.loads(self.succeeds("compare", self.models["a"], self.models["again"], "--json", "-")))

    def test_files_that_are_no_models_are_refused(self):
        self.write("no.json", "{}")
        self.fails("compare", self.models["a"], "no.json", naming=("no.json",))
        self.fails("compare", "missing.json", self.models["a"], naming=("missing.json",))


if __name__ == "__main__":
    annulus_cli.main()
