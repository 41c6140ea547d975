#!/usr/bin/python3
"""The customer's PDF sheet, read by poppler's programs: values, languages, units, fonts, and the same bytes each time."""

import re
import shutil
import subprocess
import unittest

import annulus_cli
import vase_scan
from annulus_cli import ProgramTest

HAS_POPPLER = shutil.which("pdftotext") and shutil.which("pdffonts") and shutil.which("pdfinfo")


def eighths(mm):
    """Inches in eighths as people write them."""
    whole, part = divmod(round(mm / 25.4 * 8), 8)
    half = {0: "", 1: "1/8", 2: "1/4", 3: "3/8", 4: "1/2", 5: "5/8", 6: "3/4", 7: "7/8"}[part]
    return f"{whole} {half}".strip()


@unittest.skipUnless(HAS_POPPLER, "poppler is not installed: apt-get install poppler-utils")
class Sheet(ProgramTest):
    @classmethod
    def setUpClass(cls):
        case = cls("runTest")
        case.setUp()
        cls.addClassCleanup(case.doCleanups)
        case.write("vase.csv", vase_scan.csv())
        case.succeeds("import", "vase.csv", "--out", "scan.mcap")
        case.succeeds("fit", "scan.mcap", "--out", "model.json")
        cls.model = case.path("model.json")

    def runTest(self):
        """Only gives setUpClass a test case."""

    def sheet(self, *options):
        """Writes sheet.pdf; returns its text with the layout of the page."""
        self.succeeds("measure", self.model, "--out", "sheet.pdf", *options)
        return self.poppler("pdftotext", "-layout", "sheet.pdf", "-")

    def poppler(self, *arguments):
        return subprocess.run(arguments, cwd=self.folder, capture_output=True, text=True, check=True).stdout

    def measured(self):
        table = self.succeeds_json("measure", self.model)
        return {m["id"]: m for m in table["measurements"]}

    def row(self, text, term):
        """The line of the table that begins with the term, without its number."""
        for line in text.splitlines():
            if re.match(rf"\s*(\d+\s+)?{re.escape(term)}\s\s", line):
                return line
        return self.fail(f"no row {term!r} in {text}")

    def test_every_measurement_has_a_row_with_its_value(self):
        text = self.sheet()
        for m in self.measured().values():
            row = self.row(text, m["term"])
            if "value_mm" in m:
                self.assertIn(f"{m['value_mm']:.1f} mm", re.sub(r"\s+", " ", row))
            self.assertIn(" %", row)

    def test_units_are_the_customer_s(self):
        waist = self.measured()["waist_girth"]
        centimetres = re.sub(r"\s+", " ", self.row(self.sheet("--units", "cm"), waist["term"]))
        self.assertIn(f"{waist['value_mm'] / 10:.1f} cm", centimetres)
        inches = re.sub(r"\s+", " ", self.row(self.sheet("--units", "inch"), waist["term"]))
        self.assertIn(f"{eighths(waist['value_mm'])} in", inches)

    def test_a_japanese_sheet_has_the_field_s_terms(self):
        text = self.sheet("--language", "ja", "--subject", "山田 花子")
        for word in ("人体計測結果", "胴囲(ウエスト)", "腰囲(ヒップ)", "周径", "高径", "実測率", "正面", "背面", "山田 花子"):
            self.assertIn(word, text)
        self.assertNotIn("Waist", text)

    def test_fonts_are_embedded(self):
        self.sheet("--language", "ja")
        fonts = self.poppler("pdffonts", "sheet.pdf").splitlines()[2:]
        self.assertTrue(fonts)
        for font in fonts:
            self.assertRegex(font, r"\byes\s+yes\s+yes\b")  # embedded, subset, with a table of letters

    def test_pages_are_a4_and_name_the_scan(self):
        text = self.sheet("--subject", "K-0042")
        info = self.poppler("pdfinfo", "sheet.pdf")
        self.assertRegex(info, r"Page size:\s+595\.2\d+ x 841\.8\d+ pts \(A4\)")
        self.assertIn("K-0042", text)
        scan_hash = self.read_json(self.model)["provenance"]["recording_hash"]
        self.assertIn(scan_hash[:23], text)
        pages = int(re.search(r"Pages:\s+(\d+)", info).group(1))
        self.assertIn(f"Page {pages}", text)

    def test_the_interval_is_said_to_be_within_a_limit_and_nothing_to_conform(self):
        text = re.sub(r"\s+", " ", self.sheet())
        self.assertIn("not on conformity with the standard", text)
        self.assertIn("9 mm", text)

    def test_the_same_model_gives_the_same_bytes_and_no_date(self):
        self.sheet()
        first = self.read("sheet.pdf")
        self.sheet()
        self.assertEqual(self.read("sheet.pdf"), first)
        self.assertIn("2000", re.search(r"CreationDate:.*", self.poppler("pdfinfo", "sheet.pdf")).group(0))

    def test_a_language_or_unit_that_is_not_there_is_wrong_usage(self):
        for options in (("--language", "fr"), ("--units", "ell")):
            with self.subTest(options):
                self.assertEqual(self.run_program("measure", self.model, "--out", "s.pdf", *options).returncode, 2)
        self.assertEqual(self.listing(), {})


if __name__ == "__main__":
    annulus_cli.main()
