#!/usr/bin/python3
"""Our fitter on the scans of fitpack_peer.py, through the program as a user runs it: raw scan in, error against the truth out.

usage: program_quality.py PATH/TO/annulus [--out FILE.json]
"""

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scripts"))
import fitpack_peer  # pylint: disable=wrong-import-position
import ring_data  # pylint: disable=wrong-import-position

METHODS = ("adaptive", "uniform")


def judge(program, folder, name, method):
    noisy, clean, _ = ring_data.load(folder, name)
    with tempfile.TemporaryDirectory() as work:

        def run(*arguments):
            subprocess.run([program, *arguments], cwd=work, check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)

        run("import", noisy, "--out", "scan.mcap")
        run("fit", "scan.mcap", "--out", "model.json", "--report", "report.json", "--method", method)
        with open(os.path.join(work, "grid.csv"), "w", encoding="utf-8") as f:
            f.write("theta_deg,z_mm\n")
            f.writelines(f"{2 * sensor},{z}\n" for z in clean.z_mm for sensor in range(ring_data.SENSORS))
        run("eval", "model.json", "--points", "grid.csv", "--out", "fitted.csv")
        with open(os.path.join(work, "fitted.csv"), encoding="utf-8") as f:
            fitted = np.array([float(row["r_mm"] or "nan") for row in csv.DictReader(f)]).reshape(clean.radius_mm.shape)
        with open(os.path.join(work, "report.json"), encoding="utf-8") as f:
            report = json.load(f)
    core, flat = ring_data.core_and_flat_rms(fitted - clean.radius_mm, clean)
    return {"scan": name, "method": method, "core_rms_mm": core, "flat_rms_mm": flat, "time_ms": 1e3 * report["time_s"]["total"],
            "coefficients": report["coefficients"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--out", required=True)
    arguments = parser.parse_args()
    folder = ring_data.data_folder()
    program = os.path.abspath(arguments.program)
    results = [judge(program, os.path.abspath(folder), name, method) for name in fitpack_peer.SCANS for method in METHODS] if folder else []
    with open(arguments.out, "w", encoding="utf-8") as f:
        json.dump({"annulus": results}, f, indent=1)


if __name__ == "__main__":
    main()
