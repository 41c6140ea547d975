"""The shared ring scans of shapes that nobody in the project wrote, and how a fit is judged on them.

The definitions of "core", "flat" and of the levels on which girths count are those of docs/verification.md.
"""

import csv
import gzip
import json
import os
import sys

import numpy as np
from scipy.spatial import ConvexHull, QhullError

SOURCE_DIR = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
NAMES = ("head_leeperrysmith", "head_ict_mix", "torso_mean_female", "body_mean_female", "body_arms_mh_female")
SENSORS = 180


def data_folder():
    """The folder with the scans: $ANNULUS_DATA, else ../shared/data beside the project; None without."""
    folder = os.environ.get("ANNULUS_DATA") or os.path.join(os.path.dirname(SOURCE_DIR), "shared", "data")
    return folder if os.path.isdir(folder) else None


def data_or_leave():
    """The folder with the scans; without one says so and ends the process successfully."""
    folder = data_folder()
    if folder is None:
        print("no data: set ANNULUS_DATA to the folder with *_noisy.csv.gz, *_clean.csv.gz and *_truth.json")
        sys.exit(0)
    return folder


class Grid:
    """One scan: z_mm of each level (top first), and radius_mm[level, sensor], NaN where no return came."""

    def __init__(self, path):
        with gzip.open(path, "rt", encoding="utf-8") as f:
            header = f.readline()
            rows = list(csv.DictReader(f))
        ring_radius = float(header.split("R_mm=")[1].split(";")[0])
        levels = 1 + max(int(row["level"]) for row in rows)
        self.z_mm = np.full(levels, np.nan)
        self.radius_mm = np.full((levels, SENSORS), np.nan)
        for row in rows:
            level = int(row["level"])
            self.z_mm[level] = float(row["z_mm"])
            self.radius_mm[level, int(row["sensor"])] = ring_radius - float(row["range_mm"])
        self.theta = np.radians(2.0 * np.arange(SENSORS))

    def core_levels(self):
        """Levels on which all 180 returns exist, less the top two of them."""
        return np.flatnonzero(np.isfinite(self.radius_mm).all(axis=1))[2:]

    def flat(self):
        """Cells not within 3 cells of a second difference over 2 mm, along theta or z."""
        r = self.radius_mm
        along_theta = np.roll(r, 1, axis=1) - 2 * r + np.roll(r, -1, axis=1)
        along_z = np.zeros_like(r)
        along_z[1:-1] = r[2:] - 2 * r[1:-1] + r[:-2]
        rough = (np.abs(along_theta) > 2) | (np.abs(along_z) > 2)
        near = np.zeros_like(rough)
        for rows in range(-3, 4):
            shifted = np.zeros_like(rough)
            shifted[max(0, rows):len(r) + min(0, rows)] = rough[max(0, -rows):len(r) - max(0, rows)]
            for columns in range(-3, 4):
                near |= np.roll(shifted, columns, axis=1)
        return ~near

    def hull_perimeter(self, level):
        """Of the convex hull of a level's points, mm; NaN where there is none."""
        r = self.radius_mm[level]
        try:
            # In two dimensions SciPy's "area" of a hull is its perimeter.
            return ConvexHull(np.column_stack((r * np.cos(self.theta), r * np.sin(self.theta)))).area
        except (QhullError, ValueError):
            return np.nan


def load(folder, name):
    """(noisy path, clean Grid, truth)."""
    with open(os.path.join(folder, f"{name}_truth.json"), encoding="utf-8") as f:
        truth = json.load(f)
    return os.path.join(folder, f"{name}_noisy.csv.gz"), Grid(os.path.join(folder, f"{name}_clean.csv.gz")), truth


def counted_sections(clean, truth):
    """The true sections on which a girth can be judged: one loop around the axis, on a level with all 180 returns, where
    the hull of the clean points is within 1 mm of the true one (elsewhere 2° sampling cannot see the answer)."""
    for section in truth["sections"]:
        level = np.flatnonzero(np.abs(clean.z_mm - section["z_mm"]) < 1e-6)
        if level.size and section["axis_inside"] and section["n_loops"] == 1 and np.isfinite(clean.radius_mm[level[0]]).all():
            if abs(clean.hull_perimeter(level[0]) - section["hull_perimeter_mm"]) <= 1.0:
                yield section


def other_sections(clean, truth):
    """The sections that do not count, of those whose truth has an outline."""
    counted = {section["z_mm"] for section in counted_sections(clean, truth)}
    return [section for section in truth["sections"]
            if section["z_mm"] not in counted and "hull_perimeter_mm" in section]


# What must hold of one scan's girths, and of all scans' together.
GIRTH_MUSTS = {
    "tape mean, mm": lambda figure: abs(figure) <= 0.4,
    "tape within 1 mm, share": lambda figure: figure >= 0.95,
    "tape worst, mm": lambda figure: figure <= 2.5,
    "perimeter mean, mm": lambda figure: abs(figure) <= 0.4,
    "area mean, %": lambda figure: abs(figure) <= 0.05,
}


def girth_errors(sections, reports):
    """(tape mm, perimeter mm, area %): arrays of measured less true; the latter two on the levels on which they count.
    `reports` are those of the program's `section`, one per true section."""
    pairs = list(zip(sections, reports))
    seen = [(s, r) for s, r in pairs if abs(s["perimeter_mm"] - s["visible_perimeter_mm"]) <= 0.5]
    return (np.array([r["tape_mm"] - s["hull_perimeter_mm"] for s, r in pairs]),
            np.array([r["perimeter_mm"] - s["visible_perimeter_mm"] for s, r in seen]),
            np.array([100 * (r["area_mm2"] / s["visible_area_mm2"] - 1) for s, r in seen]))


def girth_figures(errors):
    """The figures that GIRTH_MUSTS names."""
    tape, perimeter, area = errors
    return {
        "tape mean, mm": float(tape.mean()),
        "tape within 1 mm, share": float(np.mean(np.abs(tape) <= 1.0)),
        "tape worst, mm": float(np.abs(tape).max()),
        "perimeter mean, mm": float(perimeter.mean()),
        "area mean, %": float(area.mean()),
    }


def core_and_flat_rms(error, clean):
    """RMS, mm, of `error` [level, sensor] over the core cells and over the flat ones among them; NaN cells left out."""
    levels = clean.core_levels()
    core, flat = error[levels], clean.flat()[levels]
    return float(np.sqrt(np.nanmean(core**2))), float(np.sqrt(np.nanmean(core[flat] ** 2)))
