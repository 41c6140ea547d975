#!/usr/bin/python3
"""Paper 004's figs. 6 and 7, the plane pushed by three depths, in closed form: the numbers of clay_figures.json.

Written from §3 and docs/decisions/0037 and 0041, without our C++. The plane is the top of a block of 6 × 6 × 3, so that
there is a volume to keep; b is the finger's way, R = √(b/a) its radius, ρR = √(f/e) the rim's, q = r/R. The paper's two
paraboloids do not meet at q = 1, so both are blended by S, the step of fifth degree:

    dent(q) = −b·(1 − S(q²; 0.75, 1.25))·(1 − q²)
    rim(q)  = S(q²; 0.75, 1.25)·(1 − q²/ρ²)·(1 − S(q²; 0.6ρ², ρ²))

Model 1: the rim's height k is the quotient of their volumes. f is the paper's, without the blend: a starting value.
Model 2: the block is scaled by 1 + k, k = (V0/V1)^(1/3) − 1; heights are over the plane's corners, which are scaled too.

usage: clay_figures.py --check    compare clay_figures.json beside this file with what is computed here (a CTest)
       clay_figures.py --update   write it
"""

import json
import math
import os
import sys

from scipy.integrate import quad

RADIUS, RHO = 0.98, 2.0
DEPTHS = (0.25, 0.5, 0.75)
BLOCK = 6.0 * 6.0 * 3.0
FILE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "clay_figures.json")


def step(x, low, high):
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t ** 3 * (10 - 15 * t + 6 * t * t)


def dent(q):
    return -(1 - step(q * q, 0.75, 1.25)) * (1 - q * q)


def rim(q):
    return step(q * q, 0.75, 1.25) * (1 - q * q / RHO ** 2) * (1 - step(q * q, 0.6 * RHO ** 2, RHO ** 2))


def volume(shape):
    """Of a body of revolution of that height over the plane, q in R."""
    knots = [math.sqrt(0.75), 1.0, math.sqrt(1.25), math.sqrt(0.6) * RHO]
    whole = quad(lambda q: shape(q) * q, 0.0, RHO, points=knots, epsabs=1e-13, epsrel=1e-12)[0]
    return 2 * math.pi * RADIUS ** 2 * whole


def highest(height):
    return max(height(RHO * n / 20000) for n in range(20001))


def figures():
    result = {"radius_mm": RADIUS, "rho": RHO, "volume_mm3": BLOCK, "fig6": [], "fig7": []}
    for depth in DEPTHS:
        k = -depth * volume(dent) / volume(rim)
        a = depth / RADIUS ** 2
        e = depth ** 2 / (a * ((RHO * RADIUS) ** 2 - depth / a) ** 2)
        result["fig6"].append({"depth_mm": depth, "k_mm": k, "f_mm": e * (RHO * RADIUS) ** 2, "dent_mm": -depth,
                               "rim_mm": highest(lambda q: depth * dent(q) + k * rim(q))})
        k = (BLOCK / (BLOCK + depth * volume(dent))) ** (1 / 3) - 1
        result["fig7"].append({"depth_mm": depth, "k": k, "dent_mm": -(1 + k) * depth,
                               "lip_mm": (1 + k) * highest(lambda q: depth * dent(q))})
    return result


def same(a, b):
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    return math.isclose(a, b, rel_tol=1e-9)


def main():
    if sys.argv[1:] == ["--update"]:
        with open(FILE, "w", encoding="utf-8") as file:
            json.dump(figures(), file, indent=1)
            file.write("\n")
        return 0
    if sys.argv[1:] != ["--check"]:
        print(__doc__)
        return 2
    with open(FILE, encoding="utf-8") as file:
        stored = json.load(file)
    if same(stored, figures()):
        return 0
    print(FILE + " is not what this script computes: look why, then --update")
    return 1


if __name__ == "__main__":
    sys.exit(main())
