#!/usr/bin/python3
"""calibrate on the simulated booth: guided run, report, CAL.json, and what scans with it, or without it, are worth."""

import json
import math
import os
import shutil
import subprocess
import unittest

import annulus_cli
from annulus_cli import ProgramTest

PLAN = """technician = "T. Ester"
ambient_c = 21.0
[[target]]
spec = "cylinder:radius_mm=150,u_mm=0.02,serial=C-150,certificate=K-4711,height_mm=1300"
[[target]]
spec = "cylinder:radius_mm=70,u_mm=0.02,serial=C-70,certificate=K-4712,height_mm=1300"
[[target]]
spec = "cylinder:radius_mm=110,u_mm=0.02,serial=C-110,certificate=K-4713,height_mm=1300"
verify = true
"""
# As few levels as the ring can: 15 a second at the carriage's highest speed.
COARSE = """[profile.target]
pitch_mm = 20.0
speed_mm_s = 300.0
[profile.belt]
z_top_mm = 1250.0
z_bottom_mm = 950.0
pitch_mm = 10.0
speed_mm_s = 300.0
"""
RING = "[sim]\nring_errors = 1\nring_seed = 5\n"
GIRTH = 900.0
COLUMN = f"[sim.target]\nradius_mm = {GIRTH / math.tau!r}\nheight_mm = 1500\nx_mm = 25\ny_mm = -15\n"


class Calibrate(ProgramTest):
    """The ring is calibrated once for all tests; what each test writes goes into the same folder."""

    @classmethod
    def setUpClass(cls):
        case = cls("runTest")
        ProgramTest.setUp(case)
        cls.addClassCleanup(case.doCleanups)
        case.write("plan.toml", PLAN)
        case.write("ring.toml", COARSE + RING)
        cls.done = case.run_program("calibrate", "--target", "plan.toml", "--config", "ring.toml", "--out", "CAL.json",
                                    "--report", "report", "--json", "result.json", timeout=600)
        cls.case = case

    def setUp(self):
        self.folder = self.case.folder

    def runTest(self):
        """Only gives setUpClass a test case."""

    def scan(self, name, config, profile="belt"):
        """A scan of a booth with this configuration, and its model; the model's name."""
        self.write(name + ".toml", COARSE + config)
        self.succeeds("scan", "--config", name + ".toml", "--profile", profile, "--out", name + ".mcap")
        self.succeeds("fit", name + ".mcap", "--out", name + ".json")
        return name + ".json"

    def test_the_guided_run_passes_and_says_what_to_do(self):
        self.assertEqual(self.done.returncode, 0, self.done.stderr)
        said = self.done.stderr
        self.assertIn("placement 1 of 10: stand the cylinder of 150 mm radius (C-150) in the middle", said)
        self.assertIn("placement 10 of 10 (verification)", said)
        self.assertIn("of 55 s", said)
        self.assertIn("known so far: radius common to all", said)
        self.assertIn("traceable to the certificates K-4711", self.done.stdout)
        self.assertIn("calibration: CAL.json", self.done.stdout)

    def test_the_json_has_its_keys(self):
        result = self.read_json("result.json")
        self.assertEqual(set(result), {"passed", "traceable", "calibration", "hash", "time_s", "noise_mm", "chi_square",
                                       "quadratic", "placements", "observability", "budget_900_mm", "limits", "findings",
                                       "unobservable", "traceability", "verification", "plots"})
        self.assertTrue(result["passed"])
        self.assertTrue(result["traceable"])
        self.assertEqual(result["calibration"], "CAL.json")
        self.assertEqual(result["hash"], self.read_json("CAL.json")["hash"])
        self.assertEqual(len(result["placements"]), 9)
        self.assertAlmostEqual(result["noise_mm"], 0.5, delta=0.1)
        self.assertTrue(all(line["pass"] for line in result["limits"]), result["limits"])
        unknown = {one["name"] for one in result["observability"] if not one["observable"]}
        self.assertIn("z scale", unknown)
        self.assertIn("temperature coefficient", unknown)
        self.assertEqual(set(self.read_json("CAL.json")["unobservable"]), unknown)
        self.assertEqual(result["unobservable"], self.read_json("CAL.json")["unobservable"])
        self.assertIn("K-4711", result["traceability"])
        verification = result["verification"]
        self.assertEqual(verification["certified_radius_mm"], 110)
        self.assertEqual(verification["certified_u_mm"], 0.02)
        self.assertAlmostEqual(verification["found_radius_mm"], 110, delta=0.2)
        of_difference = math.hypot(verification["found_u_mm"], verification["certified_u_mm"])
        self.assertAlmostEqual(verification["en"], abs(verification["found_radius_mm"] - 110) / of_difference, places=6)
        self.assertEqual(len(verification["sensor_residual_mm"]), 180)

    def test_the_json_holds_what_is_plotted_of_each_sensor(self):
        plots = self.read_json("result.json")["plots"]
        carriage = plots.pop("carriage")
        self.assertEqual({name: len(of_sensors) for name, of_sensors in plots.items()},
                         dict.fromkeys(["before_mm", "after_mm", "half95_mm", "lateral_deg", "lateral_half95_deg",
                                        "vertical_deg", "vertical_half95_deg"], 180))
        self.assertLess(max(map(abs, plots["after_mm"])), max(map(abs, plots["before_mm"])))
        self.assertEqual(len(carriage["x_mm"]), len(carriage["z_mm"]))
        self.assertEqual(len(carriage["y_mm"]), len(carriage["z_mm"]))
        self.assertEqual(carriage["z_mm"], sorted(carriage["z_mm"]))

    def test_the_report_holds_the_certificate(self):
        page = self.read("report/report.html").decode()
        self.assertIn("K-4711", page)
        self.assertIn(self.read_json("CAL.json")["hash"], page)
        self.assertTrue(self.read("report/report.pdf").startswith(b"%PDF"))
        self.assertEqual({n for n in os.listdir(self.path("report")) if n.endswith(".mcap")},
                         {f"placement-{k}.mcap" for k in range(1, 11)})
        if shutil.which("pdftotext"):
            text = subprocess.run(["pdftotext", "-layout", self.path("report/report.pdf"), "-"], capture_output=True,
                                  text=True, check=True).stdout
            self.assertIn("K-4711", text)
            self.assertIn("C-110", text)
            self.assertIn("T. Ester", text)

    def test_the_same_scans_give_the_same_calibration(self):
        scans = [f"report/placement-{k}.mcap" for k in range(1, 11)]
        self.succeeds("calibrate", "--target", "plan.toml", "--scans", *scans, "--out", "again.json")
        first, again = self.read_json("CAL.json"), self.read_json("again.json")
        self.assertEqual(first["calibration"], again["calibration"])
        self.assertEqual(first["hash"], again["hash"])

    def test_a_girth_is_right_with_the_calibration_and_far_off_without(self):
        use = '[calibration]\nfile = "CAL.json"\n'
        right = self.succeeds_json("section", self.scan("column", RING + COLUMN + use), "--z", 1100)
        self.assertLessEqual(abs(right["tape_mm"] - GIRTH), 1.96 * right["tape_sigma_mm"], right)
        self.assertLess(right["tape_sigma_mm"], 0.5)
        wrong = self.succeeds_json("section", self.scan("raw", RING + COLUMN), "--z", 1100)
        self.assertGreater(abs(wrong["tape_mm"] - GIRTH), 2.0, wrong)

    def test_a_measurement_of_a_person_knows_what_the_calibration_leaves(self):
        use = '[calibration]\nfile = "CAL.json"\n'
        ideal = self.scan("ideal", "")
        person = self.scan("person", RING + use)
        table = self.succeeds_json("measure", person)
        self.assertNotIn("calibration", table["errors_left_out"])
        waist = next(m for m in table["measurements"] if m["id"] == "waist_girth_taut")
        self.assertGreater(waist["sigma_parts_mm"]["calibration"], 0.0)
        truth = next(m for m in self.succeeds_json("measure", ideal)["measurements"] if m["id"] == "waist_girth_taut")
        both = math.hypot(waist["sigma_mm"], truth["sigma_mm"])
        self.assertLess(abs(waist["value_mm"] - truth["value_mm"]), 3 * both, (waist, truth))
        uncalibrated = self.scan("unmarked", RING)
        self.assertIn("calibration", self.succeeds_json("measure", uncalibrated)["errors_left_out"])
        self.assertIn("not in ±: errors common to the ring's sensors", self.succeeds("measure", uncalibrated))
        self.assertNotIn("errors common to the ring's sensors", self.succeeds("measure", person))

    def test_the_recording_keeps_the_calibration_when_the_file_is_gone(self):
        shutil.copy(self.path("CAL.json"), self.path("gone.json"))
        self.scan("kept", RING + '[calibration]\nfile = "gone.json"\n')
        os.remove(self.path("gone.json"))
        self.succeeds("fit", "kept.mcap", "--out", "kept2.json")
        self.assertEqual(self.read("kept.json"), self.read("kept2.json"))

    def test_a_ring_that_is_not_calibrated_is_refused_if_the_booth_wants_it(self):
        self.write("refuse.toml", COARSE + RING + '[calibration]\nuncalibrated = "refuse"\n')
        self.fails("scan", "--config", "refuse.toml", "--profile", "belt", "--out", "no.mcap",
                   naming=["the ring is not calibrated", "annulus calibrate"])

    def test_the_calibration_of_another_ring_is_refused_and_so_is_a_damaged_one(self):
        other = self.read_json("CAL.json")
        other["boards"][3]["serial"] = 77
        self.write("other.json", json.dumps(other))
        self.write("other.toml", COARSE + RING + '[calibration]\nfile = "other.json"\n')
        self.fails("scan", "--config", "other.toml", "--profile", "belt", "--out", "no.mcap",
                   naming=["other.json", "hash does not fit"])
        self.write("none.toml", COARSE + RING + '[calibration]\nfile = "nowhere.json"\n')
        self.fails("scan", "--config", "none.toml", "--profile", "belt", "--out", "no.mcap", naming=["nowhere.json"])

    def test_a_target_that_is_pushed_is_refused_after_three_tries(self):
        pushed = "[sim.target]\nradius_mm = 150\nmoved_at_s = 12\nmoved_x_mm = 2\n"
        self.write("pushed.toml", COARSE + RING + pushed)
        done = self.run_program("calibrate", "--target", "plan.toml", "--config", "pushed.toml", "--out", "no.json",
                                "--report", "pushed")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr.count("leave it alone and scan again"), 4, done.stderr)  # and in the last line
        self.assertIn("placement 1 did not succeed in 3 tries", done.stderr)
        self.assertFalse(os.path.exists(self.path("no.json")))

    def test_wrong_usage_is_told(self):
        self.fails("calibrate", "--target", "plan.toml", "--out", "no.json", status=2, naming=["--config"])
        self.fails("calibrate", "--target", "plan.toml", "--config", "ring.toml", "--out", "no.json", status=2,
                   naming=["--report"])
        self.fails("calibrate", "--target", "plan.toml", "--scans", "a.mcap", "--out", "no.json", status=2,
                   naming=["10 placements"])
        self.fails("calibrate", "--target", "plan.toml", "--scans", "a.mcap", "--out", "no.json", "--board", "1004",
                   status=2, naming=["--previous"])
        self.fails("calibrate", "--target", "none.toml.toml", "--out", "no.json", naming=["none.toml.toml"])

    def test_one_place_only_is_refused_and_the_finding_says_why(self):
        done = self.run_program("calibrate", "--target", "cylinder:radius_mm=150,u_mm=0.02,height_mm=1300", "--scans",
                                "report/placement-1.mcap", "--out", "no.json", "--json", "one.json")
        self.assertEqual(done.returncode, 1)
        codes = {finding["code"] for finding in self.read_json("one.json")["findings"]}
        self.assertIn("one_placement", codes)
        self.assertIsNone(self.read_json("one.json")["calibration"])
        self.assertFalse(os.path.exists(self.path("no.json")))

    def test_a_second_calibration_says_what_was_as_found(self):
        scans = [f"report/placement-{k}.mcap" for k in range(1, 11)]
        self.succeeds("calibrate", "--target", "plan.toml", "--scans", *scans, "--out", "second.json", "--previous",
                      "CAL.json", "--report", "second")
        second = self.read_json("second.json")
        self.assertEqual([entry["hash"] for entry in second["history"]], [self.read_json("CAL.json")["hash"]])
        self.assertAlmostEqual(second["history"][0]["common_shift_mm"], 0.0, places=6)
        self.assertIn("As found", self.read("second/report.html").decode())


if __name__ == "__main__":
    annulus_cli.main()
