#!/usr/bin/python3
"""The tables of `./dev bench`, ready for docs/benchmarks.md.

usage: report.py GOOGLE_BENCHMARK.json PROGRAM_QUALITY.json PEER.json…
"""

import json
import sys


def load(path):
    with open(path, encoding="utf-8") as f:
        return json.load(f)


COUNTERS = {"to_coefficients_ms": "samples to coefficients {:.4g} ms", "coefficients": "{:.0f} coefficients", "rms_mm": "RMS {:.3f} mm",
            "solver_steps": "{:.0f} solver steps", "largest_difference_mm": "within {:.1e} mm of ours",
            "bytes_per_sample": "{:.0f} B per sample", "longest_preview_ms": "longest preview {:.3g} ms",
            "after_last_level_ms": "longest end {:.3g} ms", "lost_frames": "{:.0f} frames lost", "levels": "{:.0f} levels",
            "touched": "{:.0f} patches touched", "patches": "of {:.0f}", "volume_error": "volume within {:.1e} of itself",
            "cpu_percent_at_50": "{:.2g} % of a core at 50 levels/s"}


def print_benchmarks(results):
    print("| benchmark | time | rate | |\n|---|---|---|---|")
    for run in results["benchmarks"]:
        if run.get("error_occurred"):
            print(f"| {run['name']} | {run['error_message']} | | |")
            continue
        rate = f"{run['items_per_second'] / 1e6:.2f} M items/s" if "items_per_second" in run else ""
        notes = [text.format(run[key]) for key, text in COUNTERS.items() if isinstance(run.get(key), float)]
        print(f"| {run['name']} | {run['real_time']:.4g} {run['time_unit']} | {rate} | {', '.join(notes)} |")


def print_searches(results):
    """k of the clay's volume equation by bisection over the whole body, over ours; above 1 we are faster."""
    times = {run["name"]: run["cpu_time"] for run in results["benchmarks"] if not run.get("error_occurred")}
    for name, naive in times.items():
        ours = times.get(name.replace("NaiveSearchForK", "OurSearchForK"))
        if name.startswith("NaiveSearchForK/") and ours:
            print(f"\n{name}: {naive / ours:.0f} times the processor time of OurSearchForK")


def print_peers(ours, peers):
    """Our methods and each peer on the same scan; ratios are to the default method (adaptive), below 1 is better than it."""
    print("\n| scan | method | core RMS mm | flat RMS mm | fit ms | coefficients | core ratio | time ratio |\n|---|---|---|---|---|---|---|---|")
    for scan in dict.fromkeys(row["scan"] for row in ours):
        rows = [(f"annulus {row['method']}, raw scan", row) for row in ours if row["scan"] == scan]
        rows += [(name, p) for name, list_of in peers for p in list_of if p["scan"] == scan]
        first = rows[0][1]
        for name, row in rows:
            print(f"| {scan} | {name} | {row['core_rms_mm']:.3f} | {row['flat_rms_mm']:.3f} | {row['time_ms']:.0f} | "
                  f"{row['coefficients']} | {row['core_rms_mm'] / first['core_rms_mm']:.2f} | {row['time_ms'] / first['time_ms']:.2f} |")
    if not ours:
        print("\nno data: set ANNULUS_DATA for the comparison with peers")


def print_renderers(contests):
    """Our path tracer and povray on the same scenes. The error is against the same program's own converged picture (root mean
    square of sRGB values); ratio: povray's processor time over ours at povray's error, above 1 we are faster."""
    print("\n| TraceBesidePovray: scene | program | setting | error /255 | time ms | processor ms | ratio | ratio, denoised |"
          "\n|---|---|---|---|---|---|---|---|")
    for contest in contests:
        for row in contest["points"]:
            ratios = [f"{row[key]:.1f}" if key in row else "" for key in ("ratio", "ratio_denoised")]
            print(f"| {contest['scene']}, {contest['size']} x {contest['size']} | {row['program']} | {row['setting']} | "
                  f"{row['error_255']:.2f} | {row['time_ms']:.0f} | {row['cpu_ms']:.0f} | {ratios[0]} | {ratios[1]} |")


def main(arguments):
    print_benchmarks(load(arguments[1]))
    print_searches(load(arguments[1]))
    results = [(name, rows) for path in arguments[3:] for name, rows in load(path).items()]
    print_peers(load(arguments[2])["annulus"], [(f"{name}, cleaned scan", rows) for name, rows in results if name == "fitpack"])
    for name, rows in results:
        if name == "trace_beside_povray":
            print_renderers(rows)


if __name__ == "__main__":
    main(sys.argv)
