#!/usr/bin/python3
"""FITPACK regrid (SciPy's RectBivariateSpline) on the shared scans, as a yardstick for our fitter.

FITPACK cannot take the raw scan: an outlier or a hole ruins it. So outliers are removed and gaps filled first, and its
smoothing factor is chosen by looking at the answer; both favour it. The time is that of the one best call.

usage: fitpack_peer.py [--out FILE.json]
"""

import argparse
import json
import os
import sys
import time

import numpy as np
from scipy.interpolate import RectBivariateSpline, griddata

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scripts"))
import ring_data  # pylint: disable=wrong-import-position

SCANS = ("head_leeperrysmith", "head_ict_mix", "torso_mean_female", "body_mean_female")
NOISE_MM = 0.5
WRAP = 8  # Columns repeated on either side, so that the seam at theta 0 is smooth.


def cleaned(noisy, clean):
    """The noisy radii without outliers (found by the known truth, as no program could) and with every gap filled by a cubic
    interpolation of its neighbours in (level, sensor), across the seam."""
    gap = ~np.isfinite(noisy.radius_mm) | (np.abs(noisy.radius_mm - clean.radius_mm) > 10 * NOISE_MM)
    padded = np.pad(gap, ((0, 0), (WRAP, WRAP)), mode="wrap")
    values = np.pad(noisy.radius_mm, ((0, 0), (WRAP, WRAP)), mode="wrap")
    known, wanted = np.argwhere(~padded), np.argwhere(gap)
    at = wanted + (0, WRAP)
    filled = griddata(known, values[~padded], at, method="cubic")
    outside = ~np.isfinite(filled)  # Beyond the convex hull of what is known.
    filled[outside] = griddata(known, values[~padded], at[outside], method="nearest")
    radius = noisy.radius_mm.copy()
    radius[gap] = filled
    return radius


def fit(noisy, radius, factor):
    """The spline, its radii on the grid, and the seconds that FITPACK took."""
    step = noisy.theta[1]
    theta = np.concatenate((noisy.theta[-WRAP:] - 2 * np.pi, noisy.theta, noisy.theta[:WRAP] + 2 * np.pi))
    values = np.column_stack((radius[:, -WRAP:], radius, radius[:, :WRAP]))
    z_up = noisy.z_mm[::-1]
    # Both axes in units of the grid, which FITPACK's knot search likes best.
    begin = time.perf_counter()
    spline = RectBivariateSpline(z_up / abs(z_up[1] - z_up[0]), theta / step, values[::-1], s=factor * NOISE_MM**2 * values.size)
    seconds = time.perf_counter() - begin
    return spline, spline(z_up / abs(z_up[1] - z_up[0]), noisy.theta / step)[::-1], seconds


def best(folder, name):
    noisy_path, clean, _ = ring_data.load(folder, name)
    noisy = ring_data.Grid(noisy_path)
    radius = cleaned(noisy, clean)
    results = []
    for factor in (0.9, 1.0, 1.05, 1.1, 1.2, 1.4):
        spline, fitted, seconds = fit(noisy, radius, factor)
        core, flat = ring_data.core_and_flat_rms(fitted - clean.radius_mm, clean)
        results.append({"scan": name, "core_rms_mm": core, "flat_rms_mm": flat, "time_ms": 1e3 * seconds,
                        "coefficients": int(spline.get_coeffs().size), "smoothing_factor": factor})
    return min(results, key=lambda r: r["core_rms_mm"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", help="write the results here instead of stdout")
    arguments = parser.parse_args()
    folder = ring_data.data_folder()
    results = [best(folder, name) for name in SCANS] if folder else []
    if not folder:
        print("fitpack: no data", file=sys.stderr)
    text = json.dumps({"fitpack": results}, indent=1)
    if arguments.out:
        with open(arguments.out, "w", encoding="utf-8") as f:
            f.write(text + "\n")
    else:
        print(text)


if __name__ == "__main__":
    main()
