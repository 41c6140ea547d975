"""A lab trace read without our code: its records, its radii, and the boxes that they make.

usage: dcs_trace.py F.dcs      prints them
"""

import math
import sys


def read(path):
    """(records, traces): label → value of every record but R, and eye → list of radii in mm."""
    with open(path, "rb") as f:
        data = f.read()
    data.decode("ascii")
    assert data.endswith(b"\r\n") and data.count(b"\n") == data.count(b"\r\n"), "lines end in CRLF"
    records, traces, eye, count = {}, {}, None, 0
    for line in data.decode("ascii").split("\r\n")[:-1]:
        label, value = line.split("=", 1)
        if label == "TRCFMT":
            form, count, spacing, eye, _ = value.split(";")
            assert (form, spacing) == ("1", "E"), line
            traces[eye], count = [], int(count)
        elif label == "R":
            radii = [int(r) / 100 for r in value.split(";")]
            assert len(radii) <= 10, "ten radii a line"
            traces[eye] += radii
            assert len(traces[eye]) <= count
        else:
            assert label not in records, f"{label} twice"
            records[label] = value
    return records, traces


def points(radii):
    """The polygon of a trace: front view, counter-clockwise from 3 o'clock."""
    step = 2 * math.pi / len(radii)
    return [(r * math.cos(i * step), r * math.sin(i * step)) for i, r in enumerate(radii)]


def box(radii):
    """(width, height, effective diameter, circumference) of the polygon."""
    corners = points(radii)
    xs, ys = [x for x, _ in corners], [y for _, y in corners]
    centre = ((max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2)
    ed = 2 * max(math.dist(p, centre) for p in corners)
    around = sum(math.dist(corners[i - 1], corners[i]) for i in range(len(corners)))
    return max(xs) - min(xs), max(ys) - min(ys), ed, around


def pair(records, label):
    """Right and left of a chiral record; None where a side is empty."""
    return tuple(float(v) if v else None for v in records[label].split(";"))


if __name__ == "__main__":
    found, eyes = read(sys.argv[1])
    print(found)
    for side, trace in eyes.items():
        print(side, len(trace), box(trace))
