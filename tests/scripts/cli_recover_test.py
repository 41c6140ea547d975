#!/usr/bin/python3
"""recover, inspect and export of whole, damaged and unfinished recordings. HDF5 is judged by Debian's h5py."""

import json
import os

import annulus_cli
import h5py
import numpy
from annulus_cli import ProgramTest

LEVELS, SENSORS = 12, 8


def rows():
    yield "# R_mm=600"
    yield "level,z_mm,sensor,theta_deg,range_mm,t_s,sweep"
    for level in range(LEVELS):
        for sensor in range(SENSORS):
            gone = (level + sensor) % 5 == 0
            yield f"{level},{1000 - 5 * level},{sensor},{45 * sensor},{'nan' if gone else 300 + level + sensor},{level * 0.04},0"


class Recover(ProgramTest):
    def setUp(self):
        super().setUp()
        with open(self.path("p.csv"), "w", encoding="utf-8") as table:
            table.write("\n".join(rows()) + "\n")
        self.succeeds("import", self.path("p.csv"), "--out", self.path("a.mcap"))

    def damage(self, name, edit):
        data = bytearray(self.read("a.mcap"))
        edit(data)
        with open(self.path(name), "wb") as out:
            out.write(data)

    def read(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def inspect(self, name):
        return json.loads(self.succeeds("inspect", self.path(name), "--json", "-"))

    def test_a_whole_recording_is_recovered_to_the_same_bytes(self):
        self.succeeds("recover", self.path("a.mcap"), "--out", self.path("b.mcap"))
        self.assertEqual(self.read("a.mcap"), self.read("b.mcap"))

    def test_an_unfinished_recording_is_recovered(self):
        self.damage("cut.mcap", lambda data: data.__delitem__(slice(data.rindex(b"annulus.end") - 13, None)))
        report = json.loads(self.succeeds("recover", self.path("cut.mcap"), "--out", self.path("b.mcap"), "--json", "-"))
        self.assertEqual((report["lossless"], report["was_finished"], report["levels"]), (True, False, LEVELS))
        seen = self.inspect("b.mcap")
        self.assertEqual((seen["finished"], seen["recovered"], seen["levels_lost"]), (True, True, 0))
        self.assertEqual(seen["hash"], self.inspect("a.mcap")["hash"])

    def test_a_loss_is_exit_code_3_and_the_original_stays(self):
        def cut_the_middle(data):
            middle = len(data) // 2
            data[middle : middle + 40] = bytes(40)

        self.damage("bad.mcap", cut_the_middle)
        before = self.read("bad.mcap")
        done = self.run_program("recover", self.path("bad.mcap"), "--out", self.path("b.mcap"), "--json", self.path("r.json"))
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertTrue(done.stderr.startswith("annulus: recover "), done.stderr)
        self.assertEqual(self.read("bad.mcap"), before)
        with open(self.path("r.json"), encoding="utf-8") as file:
            report = json.load(file)
        lost = report["messages_lost"]["/ring/levels"]
        self.assertIn(lost, (1, 2))
        self.assertEqual(report["levels"] + lost, LEVELS)
        self.assertEqual(self.inspect("b.mcap")["levels_lost"], lost)
        self.succeeds("recover", self.path("b.mcap"), "--out", self.path("c.mcap"))
        self.assertEqual(self.read("b.mcap"), self.read("c.mcap"))

    def test_what_is_no_recording_is_exit_code_1(self):
        for name in ("p.csv", "gone.mcap"):
            done = self.run_program("recover", self.path(name), "--out", self.path("b.mcap"))
            self.assertEqual(done.returncode, 1, done.stderr)
        self.assertFalse(os.path.exists(self.path("b.mcap")))

    def test_an_existing_file_is_replaced_only_by_force(self):
        self.succeeds("recover", self.path("a.mcap"), "--out", self.path("b.mcap"))
        self.assertEqual(self.run_program("recover", self.path("a.mcap"), "--out", self.path("b.mcap")).returncode, 1)
        self.succeeds("recover", self.path("a.mcap"), "--out", self.path("b.mcap"), "--force")

    def test_a_key_file_that_others_may_read_is_refused(self):
        with open(self.path("keys"), "w", encoding="utf-8") as keys:
            keys.write(f"# test\nk1 = {'0f' * 32}\n")
        os.chmod(self.path("keys"), 0o640)
        done = self.run_program("inspect", self.path("a.mcap"), "--key-file", self.path("keys"))
        self.assertEqual(done.returncode, 1)
        self.assertIn("chmod 600", done.stderr)
        os.chmod(self.path("keys"), 0o600)
        self.succeeds("inspect", self.path("a.mcap"), "--key-file", self.path("keys"))

    def test_plain_mcap_is_exported(self):
        self.succeeds("export", self.path("a.mcap"), "--out", self.path("b.mcap"))
        self.assertEqual(self.inspect("b.mcap")["hash"], self.inspect("a.mcap")["hash"])

    def test_hdf5_holds_every_number_with_its_unit(self):
        self.succeeds("export", self.path("a.mcap"), "--out", self.path("a.h5"))
        with h5py.File(self.path("a.h5"), "r") as file:
            ranges = file["ring/range_mm"]
            self.assertEqual(ranges.attrs["units"], "mm")
            level, sensor = numpy.mgrid[0:LEVELS, 0:SENSORS]
            gone = (level + sensor) % 5 == 0
            expected = numpy.where(gone, numpy.nan, 300.0 + level + sensor)
            numpy.testing.assert_array_equal(ranges[:], expected)
            numpy.testing.assert_array_equal(file["ring/z_mm"][:], 1000.0 - 5 * level)
            numpy.testing.assert_array_equal(file["ring/time_ns"][:], numpy.arange(LEVELS) * 40_000_000)
            theta = numpy.radians(45.0 * sensor)
            points = file["ring/point_mm"][:].reshape(LEVELS, SENSORS, 3)
            numpy.testing.assert_allclose(points[..., 0], (600 - expected) * numpy.cos(theta), atol=1e-9)
            numpy.testing.assert_allclose(points[..., 1], (600 - expected) * numpy.sin(theta), atol=1e-9)
            self.assertEqual(json.loads(file["header_json"][0])["ring_radius_mm"], 600.0)
            self.assertEqual(file.attrs["scan_hash"], self.inspect("a.mcap")["hash"])
            self.assertEqual(file["bus/bytes"].shape, (0,))


if __name__ == "__main__":
    annulus_cli.main()
