#!/usr/bin/python3
"""Measurement files drive pattern programs that nobody here wrote: Debian's valentina, FreeSewing's core, xmllint."""

import json
import os
import re
import shutil
import subprocess
import unittest
import xml.etree.ElementTree as xml

import annulus_cli
import vase_scan
from annulus_cli import ProgramTest, TIME_FACTOR

HERE = os.path.dirname(os.path.abspath(__file__))
BLOCK = os.path.join(HERE, "patterns", "block.val")
SCHEMA = os.path.join(HERE, "patterns", "smis.xsd")
PEERS = os.path.join(HERE, "..", "peers")
NODE = shutil.which("node") or shutil.which("nodejs")
HAS_FREESEWING = NODE and os.path.exists(os.path.join(PEERS, "node_modules", "@freesewing", "core", "package.json"))
SVG_UNITS_PER_MM = 96 / 25.4  # CSS pixels


class Patterns(ProgramTest):
    """The model is made once: a vase with chest, waist and hip."""

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

    def measured(self):
        table = self.succeeds_json("measure", self.model)
        return {m["id"]: m.get("value_mm") for m in table["measurements"]}

    def written(self, name):
        """Writes the file; returns its measurements by name."""
        self.succeeds("measure", self.model, "--out", name)
        return {m.get("name"): float(m.get("value")) for m in xml.fromstring(self.read(name)).iter("m")}

    def valentina(self, measurements):
        """Exports the block's only piece as SVG."""
        if not shutil.which("valentina"):
            self.skipTest("valentina is not installed: apt-get install valentina")
        os.makedirs(self.path("home"), mode=0o700, exist_ok=True)
        os.makedirs(self.path("pieces"), exist_ok=True)
        shutil.copy(BLOCK, self.path("block.val"))
        # Its settings, logs and locks stay in the test's folder.
        places = {name: self.path("home") for name in ("HOME", "XDG_CONFIG_HOME", "XDG_RUNTIME_DIR", "XDG_DATA_HOME")}
        return subprocess.run(
            ["valentina", "--exportOnlyDetails", "-b", "block", "-d", "pieces", "-f", "0", "-m", measurements, "block.val"],
            cwd=self.folder, env={**os.environ, **places, "QT_QPA_PLATFORM": "offscreen"},
            stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120 * TIME_FACTOR, check=False)

    def piece_corners(self):
        """Corners of the piece in mm from its first corner."""
        (name,) = os.listdir(self.path("pieces"))
        path = re.search(r'd="M([^"]+)"', self.read(os.path.join("pieces", name)).decode()).group(1)
        corners = [tuple(float(v) / SVG_UNITS_PER_MM for v in pair.split(",")) for pair in path.split(" L")]
        return [(x - corners[0][0], y - corners[0][1]) for x, y in corners]

    def test_the_vit_file_drives_valentina_to_a_piece_of_the_body_s_size(self):
        values = self.written("body.vit")
        done = self.valentina("body.vit")
        self.assertEqual(done.returncode, 0, done.stderr)
        corners = self.piece_corners()
        for corner, name in ((1, "bust_circ"), (2, "waist_circ"), (3, "hip_circ")):
            self.assertAlmostEqual(corners[corner][0], values[name] / 4, delta=0.02, msg=name)
        for name, level in (("bust_circ", "chest"), ("waist_circ", "waist"), ("hip_circ", "hip")):
            self.assertAlmostEqual(values[name], vase_scan.girth(level), delta=2.0, msg=name)

    def test_valentina_names_a_measurement_that_is_missing(self):
        self.written("body.vit")
        lines = self.read("body.vit").decode().splitlines(keepends=True)
        self.write("body.vit", "".join(line for line in lines if 'name="bust_circ"' not in line))
        done = self.valentina("body.vit")
        self.assertEqual(done.returncode, 66, done.stderr)
        self.assertIn("additionally provide: bust_circ", done.stderr)

    def test_valentina_knows_every_name_that_we_may_write(self):
        """It refuses a file with a name that it does not know. Names not filled here are listed in the notes."""
        self.written("body.vit")
        root = xml.fromstring(self.read("body.vit"))
        missing = re.findall(r"([a-z_]+): needs ", root.findtext("notes"))
        self.assertTrue(missing)
        body = root.find("body-measurements")
        for name in missing:
            xml.SubElement(body, "m", {"name": name, "value": "100"})
        self.write("all.vit", xml.tostring(root, encoding="unicode"))
        done = self.valentina("all.vit")
        self.assertEqual(done.returncode, 0, done.stderr)
        xml.SubElement(body, "m", {"name": "annulus_unheard_of", "value": "100"})
        self.write("all.vit", xml.tostring(root, encoding="unicode"))
        self.assertIn("invalid known measurement", self.valentina("all.vit").stderr)

    def test_the_smis_file_is_valid_and_holds_the_same_measurements(self):
        self.assertEqual(self.written("body.smis"), self.written("body.vit"))
        if not shutil.which("xmllint"):
            self.skipTest("xmllint is not installed: apt-get install libxml2-utils")
        done = subprocess.run(["xmllint", "--noout", "--schema", SCHEMA, self.path("body.smis")], capture_output=True,
                              text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.write("body.smis", self.read("body.smis").decode().replace("<unit>mm", "<unit>ell"))
        done = subprocess.run(["xmllint", "--noout", "--schema", SCHEMA, self.path("body.smis")], capture_output=True,
                              text=True, check=False)
        self.assertNotEqual(done.returncode, 0, "the judge accepts anything")

    def test_every_length_is_in_the_file_once_or_under_the_program_s_names(self):
        values = self.written("body.smis")
        rounded = sorted(values.values())
        for name, value in self.measured().items():
            if value is not None:
                self.assertTrue(any(abs(value - v) <= 0.00501 for v in rounded), name)

    @unittest.skipUnless(HAS_FREESEWING, "FreeSewing is not installed: npm ci --prefix tests/peers")
    def test_the_freesewing_file_drafts_lines_of_the_body_s_size(self):
        out = self.succeeds("measure", self.model, "--out", "body.freesewing.json")
        self.assertRegex(out, "leaves out .*biceps")
        measurements = self.read_json("body.freesewing.json")
        self.assertTrue(all(isinstance(v, float) for v in measurements.values()))
        drafted = json.loads(subprocess.run(
            [NODE, os.path.join(PEERS, "draft_freesewing.mjs"), self.path("body.freesewing.json")], capture_output=True,
            text=True, check=True, timeout=60 * TIME_FACTOR).stdout)
        self.assertEqual(drafted["errors"], [])
        for name, level in (("waist", "waist"), ("seat", "hip"), ("chest", "chest")):
            self.assertAlmostEqual(drafted["lengths"][name], measurements[name] / 2, delta=1e-6)
            self.assertAlmostEqual(measurements[name], vase_scan.girth(level), delta=2.0)

    def test_files_are_in_millimetres_whatever_the_sheet_s_unit(self):
        for name in ("a.json", "a.csv", "a.vit", "a.freesewing.json"):
            self.succeeds("measure", self.model, "--out", name)
            plain = self.read(name)
            self.succeeds("measure", self.model, "--out", name, "--units", "inch", "--language", "ja")
            self.assertEqual(self.read(name), plain)

    def test_an_ending_that_is_no_format_is_wrong_usage_and_names_those_that_are(self):
        self.fails("measure", self.model, "--out", "body.xlsx", naming=(".xlsx", ".smis", ".pdf"), status=2)


if __name__ == "__main__":
    annulus_cli.main()
