#!/usr/bin/python3
"""The tables of `./dev bench`, ready for docs/benchmarks.md.

usage: report.py GOOGLE_BENCHMARK.json PROGRAM_QUALITY.json PEER.json…
"""

import json
import sys


def load(path):
    with open(path, encoding="utf-8") as f:
        return json.load(f)


def print_benchmarks(results):
    print("| benchmark | time | rate |\n|---|---|---|")
    for run in results["benchmarks"]:
        if run.get("error_occurred"):
            print(f"| {run['name']} | {run['error_message']} | |")
            continue
        rate = f"{run['items_per_second'] / 1e6:.2f} M items/s" if "items_per_second" in run else ""
        print(f"| {run['name']} | {run['real_time']:.4g} {run['time_unit']} | {rate} |")


def print_peers(ours, peers):
    """Each peer's row beside ours on the same scan; ratios are ours / the peer's, below 1 is better for us."""
    print("\n| scan | method | core RMS mm | flat RMS mm | fit ms | coefficients | core ratio | time ratio |\n|---|---|---|---|---|---|---|---|")
    for row in ours:
        rows = [("annulus, raw scan", row)] + [(name, p) for name, list_of in peers for p in list_of if p["scan"] == row["scan"]]
        for name, peer in rows:
            print(f"| {row['scan']} | {name} | {peer['core_rms_mm']:.3f} | {peer['flat_rms_mm']:.3f} | {peer['time_ms']:.0f} | "
                  f"{peer['coefficients']} | {row['core_rms_mm'] / peer['core_rms_mm']:.2f} | {row['time_ms'] / peer['time_ms']:.1f} |")
    if not ours:
        print("\nno data: set ANNULUS_DATA for the comparison with peers")


def main(arguments):
    print_benchmarks(load(arguments[1]))
    peers = [(f"{name}, cleaned scan", results) for path in arguments[3:] for name, results in load(path).items()]
    print_peers(load(arguments[2])["annulus"], peers)


if __name__ == "__main__":
    main(sys.argv)
