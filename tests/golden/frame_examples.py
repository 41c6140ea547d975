#!/usr/bin/python3
"""Paper 000's frame examples 1–4 from the paper's text alone, in numpy: the numbers of frame_examples.json.

Written from §3.2–3.5 and docs/decisions/0010, without our C++: octagon, mitred sections, bicubic patches A and B, exact
volumes by Gauss quadrature, the lens' outline sampled finely. The examples at l1 = 50 mm; the paper gives words, aspect and
d1 : d2; words are numbers by decision 0010.

usage: frame_examples.py --check    compare frame_examples.json beside this file with what is computed here (a CTest)
       frame_examples.py --update   write it
"""

import json
import os
import sys

import numpy as np

L1 = 50.0
S = L1 / 20
WORDS = {"quite square": 0.05, "slightly square": 0.12, "middle": 0.16, "slightly round": 0.20, "quite round": 0.2516,
         "extremely round": 0.32}
# name: l2/l1, words of M0 (upper outer), M3 (upper inner), M6 (lower inner), M9 (lower outer), d1, d2
EXAMPLES = {
    "example1": (1.0, ("quite square",) * 4, S, S),
    "example2": (1.0, ("quite round",) * 4, S, S),
    "example3": (0.7, ("slightly square", "slightly square", "slightly round", "slightly round"), S, S),
    "example4": (0.8, ("middle", "middle", "slightly round", "extremely round"), 1.5 * S, 0.5 * S),
}
FILE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "frame_examples.json")
X, Y, Z = np.eye(3)


def octagon(l2, cuts, d1, d2):
    """M0 … M11 of the right rim about O0 (fig. 9) and the half width there: offset from both adjoining edges."""
    corners = [np.array([sx * L1 / 2, 0, sz * l2 / 2]) for sx, sz in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    lines = []  # unit outward normal, offset of the centre line, thickness
    for k, corner in enumerate(corners):
        diagonal = np.array([np.sign(corner[0]), 0, np.sign(corner[2])]) / np.sqrt(2)
        lines.append((diagonal, corner @ diagonal - cuts[k], (d1, d1, d2, d2)[k]))
        side = (Z, -X, -Z, X)[k]
        lines.append((side, corner @ side, None))

    def meet(one, two, shift):
        (n1, c1, _), (n2, c2, _) = one, two
        x, z = np.linalg.solve([[n1[0], n1[2]], [n2[0], n2[2]]], [c1 + shift, c2 + shift])
        return np.array([x, 0, z])

    points, widths = [None] * 12, [None] * 12
    for k in range(4):
        before, cut, after = lines[(2 * k - 1) % 8], lines[2 * k], lines[2 * k + 1]
        half = cut[2] / 2
        for i, (one, two) in ((3 * k - 1, (before, cut)), (3 * k + 1, (cut, after))):
            points[i % 12] = meet(one, two, 0.0)
            widths[i % 12] = meet(one, two, half) - points[i % 12]
        points[3 * k] = cut[1] * cut[0] + (corners[k] - (corners[k] @ cut[0]) * cut[0])
        widths[3 * k] = half * cut[0]
    return points, widths


def patches(sections):
    """Control nets of A and B of a tube with sections (centre, half width, half depth), figs. 5–7."""
    a = np.array([[m - w, m - w + h, m + w + h, m + w] for m, w, h in sections])
    b = np.array([[m + w, m + w - h, m - w - h, m - w] for m, w, h in sections])
    return a, b


def bernstein(t):
    u = 1 - t
    return np.array([u**3, 3 * t * u**2, 3 * t**2 * u, t**3])


def derivative(t):
    u = 1 - t
    return np.array([-3 * u**2, 3 * u**2 - 6 * t * u, 6 * t * u - 3 * t**2, 3 * t**2])


NODES, WEIGHTS = np.polynomial.legendre.leggauss(10)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2


def flux(net):
    """(1/3)∬ S·(S_u × S_v): exact, the integrand has degree 8 in each direction."""
    total = 0.0
    for u, wu in zip(NODES, WEIGHTS):
        for v, wv in zip(NODES, WEIGHTS):
            point = np.einsum("i,j,ijk", bernstein(u), bernstein(v), net)
            along = np.einsum("i,j,ijk", derivative(u), bernstein(v), net)
            across = np.einsum("i,j,ijk", bernstein(u), derivative(v), net)
            total += wu * wv * point @ np.cross(along, across) / 3
    return total


def cap_flux(row_a, row_b):
    """The flat end inside the closed curve of A's and B's end rows: (1/6)∮ c·(r × dr), c on the plane."""
    total = 0.0
    c = row_a[0]
    for row in (row_a, row_b):
        for v, w in zip(NODES, WEIGHTS):
            total += w * c @ np.cross(bernstein(v) @ row, derivative(v) @ row) / 6
    return total


def volume(tubes, closed):
    total = sum(flux(net) for tube in tubes for net in patches(tube))
    if not closed:
        start_a, start_b = patches(tubes[0])
        end_a, end_b = patches(tubes[-1])
        total += cap_flux(start_a[0], start_b[0]) - cap_flux(end_a[3], end_b[3])
    return abs(total)


def rim_tubes(points, widths):
    h = S / 2 * Y
    return [[(points[i % 12], widths[i % 12], h) for i in range(3 * k, 3 * k + 4)] for k in range(4)]


def outline(points, widths, steps):
    """The inner outline, front view: x to the viewer's right (the wearer's left), about O0."""
    ts = np.arange(steps) / steps
    found = []
    for k in range(4):
        curve = np.array([points[i % 12] - widths[i % 12] for i in range(3 * k, 3 * k + 4)])
        found.append(np.array([bernstein(t) for t in ts]) @ curve)
    found = np.concatenate(found)
    return np.column_stack([-found[:, 0], found[:, 2]])[::-1]


def radius_at(shape, angle):
    """Distance from the origin to a closed polygon along a ray."""
    a, b = shape, np.roll(shape, -1, axis=0)
    d = np.array([np.cos(angle), np.sin(angle)])
    cross = lambda p, q: p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]
    side = b - a
    with np.errstate(divide="ignore", invalid="ignore"):
        share = -cross(a, d) / cross(side, d)
        reach = (a + share[:, None] * side) @ d
    return float(np.max(reach[(share >= 0) & (share <= 1) & (reach > 0)]))


def at_height(curve, z):
    """Point of a side's centre line at height z."""
    low, high = 0.0, 1.0
    rises = curve[3][2] > curve[0][2]
    for _ in range(100):
        middle = (low + high) / 2
        if ((bernstein(middle) @ curve)[2] < z) == rises:
            low = middle
        else:
            high = middle
    return bernstein((low + high) / 2) @ curve


def hidden_end(tube, z, width):
    """Decision 0010: both seams on the rim's centre line, 0.9 s deep."""
    curve = np.array([m for m, _, _ in tube])
    top, bottom = at_height(curve, z + width / 2), at_height(curve, z - width / 2)
    return (top + bottom) / 2, (top - bottom) / 2, 0.9 * S / 2 * Y


def moved(tube, by):
    return [(m + by, w, h) for m, w, h in tube]


def bridge_tubes(nose_side, z, d1):
    """§3.5: straight; its thirds between the ends have d1 and s."""
    centre, width, depth = hidden_end(nose_side, z, d1)
    mirror = np.array([-1, 1, 1])
    thirds = [(centre + t * (mirror * centre - centre), d1 / 2 * Z, S / 2 * Y) for t in (1 / 3, 2 / 3)]
    return [[(centre, width, depth), *thirds, (mirror * centre, mirror * width, depth)]]


def measure(name):
    aspect, words, d1, d2 = EXAMPLES[name]
    l2 = aspect * L1
    cuts = [WORDS[word] * min(L1, l2) for word in words]
    points, widths = octagon(l2, cuts, d1, d2)
    tubes = rim_tubes(points, widths)
    inner = outline(points, widths, 20000)
    low, high = inner.min(axis=0), inner.max(axis=0)
    centred = inner - (low + high) / 2
    a, b = high - low
    o0 = np.array([(L1 + L1 / 5) / 2, 0, 0])
    # The right lens' nasal side has the largest x in front view.
    dbl = 2 * (o0[0] - high[0])
    bridge = bridge_tubes(moved(tubes[1], o0), 0.6 * l2 - l2 / 2, d1)
    steps = np.linalg.norm(np.roll(inner, -1, axis=0) - inner, axis=1)
    area = 0.5 * abs(np.sum(inner[:, 0] * np.roll(inner[:, 1], -1) - np.roll(inner[:, 0], -1) * inner[:, 1]))
    return {
        "l2_mm": l2, "cuts_mm": cuts, "d1_mm": d1, "d2_mm": d2,
        "a_mm": a, "b_mm": b, "ed_mm": 2 * np.linalg.norm(centred, axis=1).max(), "dbl_mm": dbl,
        "circumference_mm": steps.sum(), "lens_area_mm2": area,
        "radii_mm": [radius_at(centred, np.radians(10 * i)) for i in range(36)],
        "rim_volume_mm3": volume(tubes, True), "bridge_volume_mm3": volume(bridge, False),
    }


def rounded(value):
    if isinstance(value, dict):
        return {k: rounded(v) for k, v in value.items()}
    if isinstance(value, list):
        return [rounded(v) for v in value]
    return round(float(value), 6)


def main():
    found = {name: rounded(measure(name)) for name in EXAMPLES}
    if sys.argv[1:] == ["--update"]:
        with open(FILE, "w", encoding="utf-8") as f:
            lines = [f' "{name}": {json.dumps(numbers)}' for name, numbers in found.items()]
            f.write("{\n" + ",\n".join(lines) + "\n}\n")
        return
    with open(FILE, encoding="utf-8") as f:
        stored = json.load(f)
    assert stored.keys() == found.keys()
    for name, numbers in found.items():
        for key, value in numbers.items():
            np.testing.assert_allclose(stored[name][key], value, rtol=0, atol=2e-6, err_msg=f"{name} {key}")
    # The roundest rim (t = 0.2516 l1) is a circle of radius 0.911 l1/2, by its centre line.
    print("frame_examples.json is what the script computes")


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1] not in ("--check", "--update"):
        sys.exit(__doc__)
    main()
