#!/usr/bin/python3
"""import → fit → section, slab, eval, measure, render, export on an elliptic cylinder, whose every measure is known."""

import csv
import json
import math
import os
import re
import struct
import zlib

import annulus_cli
from annulus_cli import CSV_COLUMNS, RING_RADIUS_MM, EllipticCylinder, ProgramTest

CYLINDER = EllipticCylinder()


def png_rows(data):
    """Width, height and the decompressed scan lines of a PNG; checks every chunk's CRC."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n", "not a PNG"
    at, compressed, size = 8, b"", None
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + length:at + 12 + length])[0], kind
        if kind == b"IHDR":
            size = struct.unpack(">II", body[:8])
        if kind == b"IDAT":
            compressed += body
        at += 12 + length
    return *size, zlib.decompress(compressed)


def one_processor():
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


class Chain(ProgramTest):
    def setUp(self):
        super().setUp()
        self.import_cylinder(CYLINDER)
        self.succeeds("fit", "scan.mcap", "--out", "model.json")

    def test_a_section_has_the_ellipse_s_girth_and_area(self):
        report = self.succeeds_json("section", "model.json", "--z", "200")
        self.assertLessEqual({"z_mm", "perimeter_mm", "tape_mm", "area_mm2", "perimeter_sigma_mm", "tape_sigma_mm",
                              "area_sigma_mm2", "measured_share"}, set(report))
        self.assertEqual(report["z_mm"], 200)
        self.assertAlmostEqual(report["perimeter_mm"], CYLINDER.perimeter, delta=0.5)
        self.assertAlmostEqual(report["tape_mm"], CYLINDER.perimeter, delta=0.5)
        self.assertAlmostEqual(report["area_mm2"], CYLINDER.area, delta=0.002 * CYLINDER.area)
        self.assertLessEqual(report["tape_mm"], report["perimeter_mm"] * (1 + 1e-6))  # the quadrature's bound
        self.assertGreater(report["measured_share"], 0.95)
        for key in ("perimeter_sigma_mm", "tape_sigma_mm"):
            self.assertTrue(0.0 < report[key] < 1.0, report)

    def test_a_tilted_section_of_a_cylinder_is_a_longer_ellipse(self):
        # A plane at angle t to the horizontal cuts a cylinder of area A in A / cos t.
        for option, degrees in (("--tilt", 25), ("--lean", -20)):
            report = self.succeeds_json("section", "model.json", "--z", "200", option, degrees)
            area = CYLINDER.area / math.cos(math.radians(degrees))
            self.assertAlmostEqual(report["area_mm2"], area, delta=0.002 * area)
            self.assertGreater(report["perimeter_mm"], CYLINDER.perimeter)
            self.assertTrue(0.0 < report["tape_sigma_mm"] < 1.0, report)
        self.fails("section", "model.json", "--z", "200", "--tilt", "70")
        self.fails("section", "model.json", "--z", "200", "--tilt", "5", "--svg", "s.svg", status=2)

    def test_a_slab_has_the_cylinder_s_volume_and_area(self):
        report = self.succeeds_json("slab", "model.json", "--z-min", "50", "--z-max", "350")
        self.assertLessEqual({"z_min_mm", "z_max_mm", "volume_mm3", "area_mm2", "volume_sigma_mm3", "area_sigma_mm2"},
                             set(report))
        self.assertAlmostEqual(report["volume_mm3"], 300 * CYLINDER.area, delta=0.002 * 300 * CYLINDER.area)
        self.assertAlmostEqual(report["area_mm2"], 300 * CYLINDER.perimeter, delta=0.002 * 300 * CYLINDER.perimeter)

    def test_places_outside_the_scan_are_refused_and_the_range_is_named(self):
        for arguments in (("section", "model.json", "--z", "401"), ("section", "model.json", "--z", "-1"),
                          ("slab", "model.json", "--z-min", "-50", "--z-max", "100"),
                          ("slab", "model.json", "--z-min", "100", "--z-max", "1e9")):
            with self.subTest(arguments):
                self.fails(*arguments, naming=("0", "400"))

    def test_a_scan_and_a_model_are_not_written_over(self):
        scan, model = self.read("scan.mcap"), self.read("model.json")
        self.fails("fit", "scan.mcap", "--out", "scan.mcap", naming=("scan.mcap", "it is the input itself"))
        self.assertEqual(self.read("scan.mcap"), scan)
        done = self.run_program("clay", "--in", "model.json", "--out-model", "model.json")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("it is the input itself", done.stderr)
        self.assertEqual(self.read("model.json"), model)

    def test_a_slab_upside_down_and_a_height_that_is_no_number_are_refused(self):
        for arguments in (("slab", "model.json", "--z-min", "200", "--z-max", "100"), ("section", "model.json", "--z", "nan"),
                          ("slab", "model.json", "--z-min", "100", "--z-max", "100")):
            with self.subTest(arguments):
                self.assertIn(self.run_program(*arguments).returncode, (1, 2))

    def test_eval_gives_radius_point_normal_and_sigma(self):
        asked = [(0, 200), (37.5, 123.4), (90, 50), (181, 390), (359.9, 200), (-30, 200)]
        self.write("asked.csv", "theta_deg,z_mm\n" + "".join(f"{t},{z}\n" for t, z in asked))
        self.succeeds("eval", "model.json", "--points", "asked.csv", "--out", "answer.csv")
        answers = list(csv.DictReader(self.read("answer.csv").decode().splitlines()))
        self.assertEqual(list(answers[0]), "theta_deg,z_mm,r_mm,x_mm,y_mm,nx,ny,nz,sigma_mm,measured".split(","))
        self.assertEqual(len(answers), len(asked))
        for (theta_deg, z), row in zip(asked, answers):
            theta = math.radians(theta_deg)
            r = CYLINDER.radius(theta)
            x, y = r * math.cos(theta), r * math.sin(theta)
            nx, ny = (x - CYLINDER.x0) / CYLINDER.a**2, (y - CYLINDER.y0) / CYLINDER.b**2
            self.assertAlmostEqual(float(row["r_mm"]), r, delta=0.5)
            self.assertAlmostEqual(float(row["x_mm"]), x, delta=0.5)
            self.assertAlmostEqual(float(row["y_mm"]), y, delta=0.5)
            cosine = (float(row["nx"]) * nx + float(row["ny"]) * ny) / math.hypot(nx, ny)
            self.assertGreater(cosine, math.cos(math.radians(3)))
            self.assertTrue(0.0 < float(row["sigma_mm"]) < 1.0, row)
            self.assertEqual(row["measured"], "measured")

    def test_eval_outside_the_scan_is_unknown_with_empty_numbers(self):
        self.write("asked.csv", "theta_deg,z_mm\n10,900\n")
        self.succeeds("eval", "model.json", "--points", "asked.csv", "--out", "answer.csv")
        row = list(csv.DictReader(self.read("answer.csv").decode().splitlines()))[0]
        self.assertEqual(row["measured"], "unknown")
        self.assertEqual({row[k] for k in ("r_mm", "x_mm", "y_mm", "nx", "ny", "nz", "sigma_mm")}, {""})

    def test_eval_refuses_a_points_file_with_letters_naming_the_line(self):
        self.write("asked.csv", "theta_deg,z_mm\n10,200\nten,200\n")
        self.fails("eval", "model.json", "--points", "asked.csv", "--out", "answer.csv", naming=("asked.csv", "line 3"))

    def test_a_picture_has_the_asked_size_and_shows_something(self):
        for view in ("front", "left45", "right45", "120,20"):
            with self.subTest(view):
                self.succeeds("render", "model.json", "--view", view, "--size", "200", "--out", "p.png")
                width, height, pixels = png_rows(self.read("p.png"))
                self.assertEqual(max(width, height), 200)
                self.assertGreater(len(set(pixels)), 20)

    def test_export_then_import_gives_the_same_readings(self):
        self.succeeds("export", "scan.mcap", "--out", "out.csv")
        self.succeeds("import", "out.csv", "--out", "again.mcap")
        self.succeeds("export", "again.mcap", "--out", "again.csv")
        self.assertEqual(self.read("out.csv"), self.read("again.csv"))
        names = CSV_COLUMNS.split(",")
        data = [line for line in self.read("out.csv").decode().splitlines() if not line.startswith("#")]
        self.assertEqual(data[0].split(",")[:5], names)
        exported = {(int(r["level"]), int(r["sensor"])): r for r in csv.DictReader(data)}
        for line in CYLINDER.rows():
            level, z, sensor, theta_deg, range_mm = (float(v) for v in line.split(","))
            row = exported.pop((int(level), int(sensor)))
            for name, value in (("z_mm", z), ("theta_deg", theta_deg)):
                self.assertAlmostEqual(float(row[name]), value, delta=1e-6)
            if math.isnan(range_mm):
                self.assertTrue(math.isnan(float(row["range_mm"])))
            else:
                self.assertAlmostEqual(float(row["range_mm"]), range_mm, delta=1e-4)
                r = RING_RADIUS_MM - range_mm
                self.assertAlmostEqual(math.hypot(float(row["x_cal_mm"]), float(row["y_cal_mm"])), r, delta=1e-3)
        self.assertEqual(exported, {})

    def test_a_compressed_file_gives_the_same_model(self):
        self.write("cylinder.csv.gz", CYLINDER.csv())
        self.succeeds("import", "cylinder.csv.gz", "--out", "gz.mcap")
        self.succeeds("fit", "gz.mcap", "--out", "gz.json")
        self.assertEqual(self.read("gz.json"), self.read("model.json"))

    def test_a_compressed_export_can_be_imported(self):
        self.succeeds("export", "scan.mcap", "--out", "out.csv.gz")
        self.succeeds("import", "out.csv.gz", "--out", "again.mcap")

    def test_the_model_is_the_same_bytes_whatever_the_number_of_threads(self):
        for number, (threads, before) in enumerate((("1", None), ("4", None), ("2", one_processor))):
            self.succeeds("fit", "scan.mcap", "--out", f"m{number}.json", env={"OMP_NUM_THREADS": threads}, before=before)
            self.assertEqual(self.read(f"m{number}.json"), self.read("model.json"))

    def test_the_model_names_no_path_and_no_machine(self):
        # Without its base64 numbers, in which a short host name may stand by chance.
        text = re.sub(r'"[A-Za-z0-9+/=]{100,}"', '""', self.read("model.json").decode())
        self.assertLess(len(text), len(self.read("model.json")))
        for word in (self.folder, "scan.mcap", os.uname().nodename):
            self.assertNotRegex(text, rf"\b{re.escape(word)}\b")

    def test_the_model_is_json_with_surfaces(self):
        model = self.read_json("model.json")
        self.assertEqual(len(model["surfaces"]), 1)

    def test_inputs_stay_as_they_were_and_nothing_but_the_output_appears(self):
        before = self.listing()
        for arguments in (("inspect", "scan.mcap"), ("inspect", "model.json"), ("section", "model.json", "--z", "100")):
            self.succeeds(*arguments)
            self.assertEqual(self.listing(), before)
        self.succeeds("fit", "scan.mcap", "--out", "new.json", "--report", "report.json")
        after = self.listing()
        self.assertEqual({k: v for k, v in after.items() if k in before}, before)
        self.assertEqual(set(after) - set(before), {"new.json", "report.json"})
        report = self.read_json("report.json")
        self.assertLessEqual({"time_s", "coefficients", "rms_mm", "rejected", "segments", "effective_parameters"}, set(report))
        self.assertAlmostEqual(report["rms_mm"], 0.3, delta=0.05)

    def test_a_recording_is_replaced_only_by_force(self):
        before = self.read("scan.mcap")
        self.fails("import", "cylinder.csv", "--out", "scan.mcap", naming=("scan.mcap", "--force"))
        self.succeeds("import", "cylinder.csv", "--out", "scan.mcap", "--force")
        self.assertEqual(self.read("scan.mcap"), before)

    def test_json_reports_go_to_a_file_too(self):
        self.succeeds("section", "model.json", "--z", "200", "--json", "report.json")
        self.assertEqual(self.read_json("report.json"), self.succeeds_json("section", "model.json", "--z", "200"))

    def test_outliers_do_not_move_the_surface(self):
        lines = CYLINDER.csv().splitlines()
        for number in range(50, len(lines), 500):
            level, z, sensor, theta_deg, _ = lines[number].split(",")
            lines[number] = f"{level},{z},{sensor},{theta_deg},300.0"
        self.write("outliers.csv", "\n".join(lines) + "\n")
        self.succeeds("import", "outliers.csv", "--out", "outliers.mcap")
        self.succeeds("fit", "outliers.mcap", "--out", "outliers.json")
        tape = json.loads(self.succeeds("section", "outliers.json", "--z", "200", "--json", "-"))["tape_mm"]
        self.assertAlmostEqual(tape, CYLINDER.perimeter, delta=0.7)


if __name__ == "__main__":
    annulus_cli.main()
