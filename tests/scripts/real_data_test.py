#!/usr/bin/python3
"""import → fit → eval, section, slab, render on the shared scans, and glasses on the heads, against the known truth.

usage: real_data_test.py PATH/TO/annulus        prints "no data" and succeeds where the scans are absent
"""

import concurrent.futures
import csv
import json
import os
import sys
import time

import numpy as np

import annulus_cli
import ring_data
from annulus_cli import ProgramTest

CORE_RMS_LIMIT_MM = {"head_leeperrysmith": 1.0}
UNKNOWN_LIMIT = 0.01  # Share of the core; a hand between ring and torso may leave a cell without an answer.
SLAB_LIMIT = 0.0003
LEVEL_STEP = 1 if os.environ.get("ANNULUS_LONG") else 3  # one level in so many
ELSEWHERE_SHARE = 0.1  # of the levels that do not count may be neither told from one loop nor held; 0 is what should be
# Known to miss ring_data.GIRTH_MUSTS on all levels (docs/decisions/0019), by how much: it may get no worse.
FALLS_SHORT = {
    ("head_leeperrysmith", "tape within 1 mm, share"): 0.94,
    ("body_arms_mh_female", "tape within 1 mm, share"): 0.72,
    ("body_arms_mh_female", "perimeter mean, mm"): 0.46,
    ("all", "tape within 1 mm, share"): 0.94,
}
# A third of the levels says less of it.
WORSE_BY = {"tape within 1 mm, share": 0.0 if LEVEL_STEP == 1 else 0.1, "perimeter mean, mm": 0.0 if LEVEL_STEP == 1 else 0.3}


class RealData(ProgramTest):
    data = ""
    errors = {}  # by scan, as ring_data.girth_errors gives them
    elsewhere = {}  # by scan: levels that do not count, wrongly called one loop, told, told and held

    def chain(self, name):
        noisy, clean, truth = ring_data.load(self.data, name)
        begin = time.monotonic()
        self.succeeds("import", noisy, "--out", "scan.mcap")
        self.succeeds("fit", "scan.mcap", "--out", "model.json", timeout=300)
        print(f"\n{name}: import and fit {time.monotonic() - begin:.1f} s")
        self.check_radii(name, clean)
        self.check_girths(name)
        self.check_slabs(truth)
        for view in ("front", "left45", "right45"):
            self.succeeds("render", "model.json", "--view", view, "--size", "300", "--out", f"{view}.png")
            self.assertEqual(self.read(f"{view}.png")[:4], b"\x89PNG")

    def check_radii(self, name, clean):
        with open(self.path("grid.csv"), "w", encoding="utf-8") as f:
            f.write("theta_deg,z_mm\n")
            f.writelines(f"{2 * sensor},{z}\n" for z in clean.z_mm for sensor in range(ring_data.SENSORS))
        self.succeeds("eval", "model.json", "--points", "grid.csv", "--out", "fitted.csv")
        with open(self.path("fitted.csv"), encoding="utf-8") as f:
            fitted = np.array([float(row["r_mm"] or "nan") for row in csv.DictReader(f)]).reshape(clean.radius_mm.shape)
        unknown = float(np.mean(np.isnan(fitted[clean.core_levels()])))
        core, flat = ring_data.core_and_flat_rms(fitted - clean.radius_mm, clean)
        print(f"  core RMS {core:.3f} mm, flat RMS {flat:.3f} mm, {100 * unknown:.2f} % of the core unknown")
        self.assertLessEqual(unknown, UNKNOWN_LIMIT)
        if name in CORE_RMS_LIMIT_MM:
            self.assertEqual(unknown, 0.0)
            self.assertLessEqual(core, CORE_RMS_LIMIT_MM[name])

    def sections_of(self, sections):
        """What the program says of true sections, in their order: the JSON, or None where it refuses."""
        def report(section):
            done = self.run_program("section", "model.json", "--z", section["z_mm"], "--json", "-")
            return json.loads(done.stdout) if done.returncode == 0 else None

        with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
            return list(pool.map(report, sections))

    def check_girths(self, name):
        """Girths on the levels that count, and elsewhere; the folder holds the scan's model."""
        _, clean, truth = ring_data.load(self.data, name)
        sections = list(ring_data.counted_sections(clean, truth))[::LEVEL_STEP]
        self.assertTrue(sections, "no section counts")
        reports = self.sections_of(sections)
        self.assertNotIn(None, reports, "a section that counts is refused")
        errors = ring_data.girth_errors(sections, reports)
        self.errors[name] = errors
        tape, perimeter, _ = errors
        held = np.mean(np.abs(tape) <= 1.96 * np.array([r["tape_sigma_mm"] for r in reports]))
        print(f"  girths on {len(tape)} levels (perimeter and area on {len(perimeter)}); the tape's 95 % interval holds the "
              f"truth on {100 * held:.0f} %")
        self.check_musts(name, ring_data.girth_figures(errors))
        self.check_elsewhere(name, ring_data.other_sections(clean, truth)[::LEVEL_STEP])

    def check_musts(self, name, figures):
        for what, figure in figures.items():
            holds = ring_data.GIRTH_MUSTS[what](figure)
            known = (name, what) in FALLS_SHORT
            print(f"    {what}: {figure:+.3f}" + ("" if holds else ", FALLS SHORT") + (" (known)" if known else ""))
            if known:
                worst = FALLS_SHORT[(name, what)]
                if what.endswith("share"):
                    self.assertGreaterEqual(figure, worst - WORSE_BY[what], f"{name}: {what} is worse than it was")
                else:
                    self.assertLessEqual(abs(figure), worst + WORSE_BY[what], f"{name}: {what} is worse than it was")
            # A third of the levels says too little of shares and means that are close to the limit.
            if not known and (LEVEL_STEP == 1 or "worst" in what or "area" in what):
                self.assertTrue(holds, f"{name}: {what} is {figure:.3f}")

    def check_elsewhere(self, name, sections):
        """A level that does not count is refused, or said not to be one visible loop, or its interval holds the truth."""
        pairs = list(zip(sections, self.sections_of(sections)))

        def holds(truth, report):
            return abs(report["tape_mm"] - truth["hull_perimeter_mm"]) <= 1.96 * report["tape_sigma_mm"]

        told = [holds(s, r) for s, r in pairs if r is not None and not r["one_visible_loop"]]
        plain = [(s, r) for s, r in pairs if r is not None and r["one_visible_loop"]]
        missed = [f"{s['z_mm']:g} ({r['tape_mm'] - s['hull_perimeter_mm']:+.1f} mm, sigma {r['tape_sigma_mm']:.2f})"
                  for s, r in plain if not holds(s, r)]
        self.elsewhere[name] = (len(pairs), len(missed), len(told), sum(told))
        print(f"  elsewhere {len(pairs)} levels: {len(pairs) - len(told) - len(plain)} refused, {len(told)} said not to be one "
              f"visible loop ({sum(told)} of these intervals hold the truth), {len(plain)} said to be one: "
              f"{len(plain) - len(missed)} intervals hold the truth" + ("".join(", not at z = " + m for m in missed)))

    def check_slabs(self, truth):
        for slab in truth["slabs"]:
            report = self.succeeds_json("slab", "model.json", "--z-min", slab["z0_mm"], "--z-max", slab["z1_mm"])
            error = report["volume_mm3"] / slab["visible_star_volume_mm3"] - 1
            print(f"  slab {slab['z0_mm']:g}..{slab['z1_mm']:g}: volume {100 * error:+.3f} %")
            self.assertLessEqual(abs(error), SLAB_LIMIT)

    def glasses(self):
        self.succeeds("glasses", "design", "--out", "frame.json")
        self.succeeds("glasses", "fit", "model.json", "--frame", "frame.json", "--out", "worn.json")
        self.succeeds("glasses", "export", "worn.json", "--out", "frame.stl")
        self.succeeds("render", "model.json", "--worn", "worn.json", "--view", "front", "--size", "300", "--out", "worn.png")
        self.assertNotEqual(self.read("worn.png"), self.read("front.png"))

    def test_zz_girths_of_all_scans_together(self):
        """Last by its name; fits what was not fitted before."""
        for name in ring_data.NAMES:
            if name not in self.errors:
                self.succeeds("import", ring_data.load(self.data, name)[0], "--out", "scan.mcap", "--force")
                self.succeeds("fit", "scan.mcap", "--out", "model.json", timeout=300)
                self.check_girths(name)
        pooled = [np.concatenate([self.errors[name][k] for name in ring_data.NAMES]) for k in range(3)]
        print("\nall scans together")
        self.check_musts("all", ring_data.girth_figures(pooled))
        levels, missed, told, held = (sum(figures) for figures in zip(*self.elsewhere.values()))
        print(f"  elsewhere {levels} levels: {told} said not to be one visible loop, {held} of these intervals hold the truth; "
              f"{missed} neither said so nor hold it")
        self.assertLessEqual(missed, ELSEWHERE_SHARE * levels)

    def test_z_outside_the_range_is_refused(self):
        noisy, clean, _ = ring_data.load(self.data, "torso_mean_female")
        self.succeeds("import", noisy, "--out", "scan.mcap")
        self.succeeds("fit", "scan.mcap", "--out", "model.json")
        self.fails("section", "model.json", "--z", clean.z_mm.max() + 50, naming=("1380",))


def add_case(name):
    def case(self):
        self.chain(name)
        if name.startswith("head"):
            self.glasses()

    setattr(RealData, f"test_{name}", case)


if __name__ == "__main__":
    RealData.data = os.path.abspath(ring_data.data_or_leave())
    for scan_name in ring_data.NAMES:
        add_case(scan_name)
    sys.stdout.reconfigure(line_buffering=True)
    annulus_cli.main()
