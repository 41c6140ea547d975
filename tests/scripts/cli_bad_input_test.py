#!/usr/bin/python3
"""Bad input and full disks: exit 1, one line that says what, where and what to do, nothing half-written."""

import os
import random
import resource
import signal
import subprocess

import annulus_cli
from annulus_cli import CSV_COLUMNS, EllipticCylinder, ProgramTest

HEADER = f"# test; R_mm=600\n{CSV_COLUMNS}\n"


def small_scan(levels=4, range_mm="450.0"):
    """Data lines of a round cylinder; the first stands on line 3 of a file that begins with HEADER."""
    return [f"{level},{100 - 10 * level}.0,{s},{2 * s},{range_mm}" for level in range(levels) for s in range(180)]


def limit_file_size(size):
    """The kernel refuses to let any file grow beyond `size` bytes: write() fails as on a full disk."""

    def before():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return before


class BadCsv(ProgramTest):
    def refuse(self, text, *naming, name="bad.csv"):
        self.write(name, text)
        return self.fails("import", name, "--out", "scan.mcap", naming=(name, *naming))

    def refuse_line(self, bad_line, *naming):
        """`bad_line` instead of the fifth data line, which is line 7 of the file."""
        lines = small_scan()
        lines[4] = bad_line
        self.refuse(HEADER + "\n".join(lines) + "\n", "line 7", *naming)

    def test_the_lines_that_the_others_spoil_are_good(self):
        self.write("good.csv", HEADER + "\n".join(small_scan()) + "\n")
        self.succeeds("import", "good.csv", "--out", "scan.mcap")

    def test_a_missing_file(self):
        self.fails("import", "nowhere.csv", "--out", "scan.mcap", naming=("nowhere.csv",))

    def test_a_folder(self):
        os.mkdir(self.path("folder.csv"))
        self.fails("import", "folder.csv", "--out", "scan.mcap", naming=("folder.csv",))

    def test_an_empty_file(self):
        self.refuse("")

    def test_a_header_only(self):
        self.refuse(HEADER)

    def test_missing_columns_are_named(self):
        self.refuse("# R_mm=600\nlevel,z_mm,sensor,theta_deg\n0,100.0,0,0\n", "range_mm")

    def test_no_ring_radius(self):
        self.refuse(CSV_COLUMNS + "\n" + "\n".join(small_scan()) + "\n", "R_mm")

    def test_a_ring_radius_that_is_no_number(self):
        self.refuse(f"# R_mm=wide\n{CSV_COLUMNS}\n" + "\n".join(small_scan()) + "\n", "R_mm")

    def test_letters_for_a_number(self):
        self.refuse_line("0,100.0,4,8,far")

    def test_a_number_with_letters_behind_it(self):
        self.refuse_line("0,100.0,4,8,450.0mm")

    def test_an_infinite_range(self):
        for text in ("inf", "-inf", "Infinity", "1e999"):
            with self.subTest(text):
                self.refuse_line(f"0,100.0,4,8,{text}")

    def test_a_height_that_is_no_number(self):
        self.refuse_line("0,nan,4,8,450.0")

    def test_a_negative_range(self):
        self.refuse_line("0,100.0,4,8,-450.0")

    def test_a_huge_range(self):
        self.refuse_line("0,100.0,4,8,1e12")

    def test_a_negative_or_fractional_sensor(self):
        for sensor in ("-4", "4.5", "99999999999999999999"):
            with self.subTest(sensor):
                self.refuse_line(f"0,100.0,{sensor},8,450.0")

    def test_too_few_fields(self):
        self.refuse_line("0,100.0,4")

    def test_a_very_long_line(self):
        self.refuse_line("0,100.0,4,8," + "4" * 1_000_000)

    def test_zero_bytes(self):
        self.refuse_line("0,100.0,4,8,\0\0")

    def test_random_bytes(self):
        self.write("noise.csv", random.Random(5).randbytes(20_000))
        self.fails("import", "noise.csv", "--out", "scan.mcap", naming=("noise.csv",))

    def test_a_truncated_gzip_file(self):
        whole = annulus_cli.gzip.compress((HEADER + "\n".join(small_scan())).encode(), mtime=0)
        self.refuse(whole[: len(whole) // 2], name="cut.csv.gz")

    def test_a_gzip_name_with_other_content(self):
        self.refuse(b"PK\x03\x04" + bytes(1000), name="zip.csv.gz")


class UnusableScan(ProgramTest):
    """A well-formed file may already be refused by import; at the latest fit says why it cannot work."""

    def refuse_somewhere(self, lines):
        self.write("odd.csv", HEADER + "\n".join(lines) + "\n")
        imported = self.run_program("import", "odd.csv", "--out", "scan.mcap")
        if imported.returncode == 0:
            self.fails("fit", "scan.mcap", "--out", "model.json", naming=("scan.mcap",))
        else:
            self.fails("import", "odd.csv", "--out", "scan.mcap", naming=("odd.csv",))

    def test_a_single_level(self):
        self.refuse_somewhere(small_scan(levels=1))

    def test_a_scan_without_one_return(self):
        self.refuse_somewhere(small_scan(range_mm="nan"))

    def test_returns_on_one_side_of_one_sensor_only(self):
        self.refuse_somewhere([f"{level},{100 - 10 * level}.0,{s},{2 * s},{450.0 if s == 7 else 'nan'}"
                               for level in range(8) for s in range(180)])


class ForeignFiles(ProgramTest):
    """Each command that reads one of our files, given something else."""

    def read_by(self, name):
        return (("fit", name, "--out", "m.json"), ("export", name, "--out", "e.csv"), ("inspect", name),
                ("section", name, "--z", "10"), ("slab", name, "--z-min", "1", "--z-max", "2"), ("measure", name),
                ("render", name, "--view", "front", "--out", "p.png"), ("glasses", "export", name, "--out", "f.stl"))

    def refuse(self, name):
        for command in self.read_by(name):
            with self.subTest(command):
                self.fails(*command, naming=(name,))

    def test_a_missing_file(self):
        self.refuse("nowhere.json")

    def test_an_empty_file(self):
        self.refuse(self.write("empty.mcap", b""))

    def test_random_bytes(self):
        self.refuse(self.write("noise.bin", random.Random(6).randbytes(5_000)))

    def test_json_of_another_kind(self):
        self.refuse(self.write("other.json", '{"surfaces": 5, "version": []}'))

    def test_deeply_nested_json(self):
        self.refuse(self.write("deep.json", "[" * 200_000))

    def test_a_truncated_recording_and_a_truncated_model(self):
        self.import_cylinder(EllipticCylinder(height=200.0))
        self.succeeds("fit", "scan.mcap", "--out", "model.json")
        whole = self.read("model.json")
        for share in (0.1, 0.5, 0.999):
            cut = self.write("cut.json", whole[: int(len(whole) * share)])
            self.fails("section", cut, "--z", "100", naming=(cut,))
        recording = self.read("scan.mcap")
        cut = self.write("cut.mcap", recording[: len(recording) // 2])
        done = self.run_program("fit", cut, "--out", "of_cut.json")
        # A recording survives a torn tail: fit may work on what is left, but it may not crash or leave half a model.
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertEqual(os.path.exists(self.path("of_cut.json")), done.returncode == 0)
        stub = self.write("stub.mcap", recording[:40])
        self.fails("fit", stub, "--out", "of_stub.json", naming=(stub,))

    def test_a_model_with_spoilt_numbers(self):
        self.import_cylinder(EllipticCylinder(height=200.0))
        self.succeeds("fit", "scan.mcap", "--out", "model.json")
        text = self.read("model.json").decode()
        spoilt = text.replace("1", "9e999", 40)
        self.assertNotEqual(text, spoilt)
        self.fails("section", self.write("spoilt.json", spoilt), "--z", "100", naming=("spoilt.json",))


class FullDisk(ProgramTest):
    def test_no_command_leaves_half_a_file(self):
        self.import_cylinder(EllipticCylinder(height=200.0))
        self.succeeds("fit", "scan.mcap", "--out", "model.json")
        for command in (("import", "cylinder.csv", "--out", "new.mcap"), ("export", "scan.mcap", "--out", "new.csv"),
                        ("fit", "scan.mcap", "--out", "new.json"),
                        ("render", "model.json", "--view", "front", "--out", "new.png")):
            with self.subTest(command):
                self.fails(*command, naming=(command[-1],), before=limit_file_size(4096))

    def test_an_existing_output_stays_as_it_was(self):
        self.import_cylinder(EllipticCylinder(height=200.0))
        self.write("model.json", "the old one")
        self.fails("fit", "scan.mcap", "--out", "model.json", naming=("model.json",), before=limit_file_size(4096))

    def test_a_small_file_system_that_is_full(self):
        os.mkdir(self.path("disk"))
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8k", "tmpfs", self.path("disk")],
                                 capture_output=True, check=False)
        if mounted.returncode != 0:
            self.skipTest("mounting needs rights that this user has not")
        self.addCleanup(subprocess.run, ["umount", self.path("disk")], check=True)
        self.import_cylinder(EllipticCylinder(height=200.0))
        self.fails("import", "cylinder.csv", "--out", "disk/scan.mcap", naming=("disk/scan.mcap",))

    def test_an_output_folder_that_does_not_exist(self):
        self.import_cylinder(EllipticCylinder(height=200.0))
        self.fails("fit", "scan.mcap", "--out", "no/such/folder/model.json", naming=("no/such/folder",))

    def test_a_device_without_space(self):
        """Reports go straight to stdout; a failed write there is an error too."""
        self.import_cylinder(EllipticCylinder(height=200.0))
        self.succeeds("fit", "scan.mcap", "--out", "model.json")
        with open("/dev/full", "wb") as full:
            done = subprocess.run([self.program, "section", "model.json", "--z", "100", "--json", "-"], cwd=self.folder,
                                  stdin=subprocess.DEVNULL, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertTrue(done.stderr.startswith("annulus: "), done.stderr)


if __name__ == "__main__":
    annulus_cli.main()
