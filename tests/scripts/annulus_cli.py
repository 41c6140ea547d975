"""What the whole-program tests share: running the program, checking its error line, and a scan with known truth.

Every test file is called with the program's path as its first argument.
"""

import gzip
import hashlib
import json
import math
import os
import random
import subprocess
import sys
import tempfile
import unittest

CSV_COLUMNS = "level,z_mm,sensor,theta_deg,range_mm"
RING_RADIUS_MM = 600.0
SLOW_BUILD = "ANNULUS_SLOW_BUILD" in os.environ
TIME_FACTOR = 10 if SLOW_BUILD else 1  # on every time limit; none of them is a requirement on speed


def take_program():
    """The program's path, removed from the arguments that unittest reads."""
    if len(sys.argv) < 2:
        sys.exit(f"usage: {sys.argv[0]} PATH/TO/annulus [unittest options]")
    return os.path.abspath(sys.argv.pop(1))


class EllipticCylinder:
    """An upright elliptic cylinder whose axis stands beside the ring's: all its measures have closed forms.

    Semi-axes a along x and b along y, centre (x0, y0), z from 0 to height; mm.
    """

    def __init__(self, a=150.0, b=100.0, x0=20.0, y0=-10.0, height=400.0, pitch=10.0):
        self.a, self.b, self.x0, self.y0, self.height, self.pitch = a, b, x0, y0, height, pitch

    def radius(self, theta):
        """Distance from the ring's axis to the wall at angle theta (rad): ((r·cos − x0)/a)² + ((r·sin − y0)/b)² = 1."""
        p, q = math.cos(theta) / self.a, math.sin(theta) / self.b
        u, v = self.x0 / self.a, self.y0 / self.b
        aa, bb, cc = p * p + q * q, p * u + q * v, u * u + v * v - 1
        return (bb + math.sqrt(bb * bb - aa * cc)) / aa

    @property
    def perimeter(self):
        """∫√(a²sin²t + b²cos²t)dt by the trapezoidal rule, which converges exponentially for periodic functions."""
        n = 720
        steps = (2 * math.pi * k / n for k in range(n))
        return sum(math.hypot(self.a * math.sin(t), self.b * math.cos(t)) for t in steps) * 2 * math.pi / n

    @property
    def area(self):
        return math.pi * self.a * self.b

    def rows(self, seed=1, noise=0.3, dropout=0.01):
        """The lines of a noisy scan from the top down."""
        rng = random.Random(seed)
        levels = int(self.height / self.pitch) + 1
        for level in range(levels):
            z = self.height - level * self.pitch
            for sensor in range(180):
                range_mm = RING_RADIUS_MM - self.radius(math.radians(2 * sensor)) + rng.gauss(0.0, noise)
                text = "nan" if rng.random() < dropout else f"{range_mm:.4f}"
                yield f"{level},{z:.3f},{sensor},{2 * sensor},{text}"

    def csv(self, **options):
        header = f"# elliptic cylinder; R_mm={RING_RADIUS_MM:g}; theta_deg=2*sensor\n{CSV_COLUMNS}\n"
        return header + "\n".join(self.rows(**options)) + "\n"


class ProgramTest(unittest.TestCase):
    """A test with its own empty folder, in which the program runs."""

    program = ""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="annulus_cli_")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, content):
        """Writes text or bytes; names that end in .gz are compressed."""
        data = content.encode() if isinstance(content, str) else content
        if name.endswith(".gz") and isinstance(content, str):
            data = gzip.compress(data, mtime=0)
        with open(self.path(name), "wb") as f:
            f.write(data)
        return name

    def read(self, name):
        with open(self.path(name), "rb") as f:
            return f.read()

    def read_json(self, name):
        return json.loads(self.read(name))

    def run_program(self, *arguments, env=None, before=None, timeout=120):
        """Runs the program in the test's folder, without a terminal."""
        return subprocess.run(
            [self.program, *map(str, arguments)], cwd=self.folder, env={**os.environ, **(env or {})}, preexec_fn=before,
            stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout * TIME_FACTOR, check=False)

    def succeeds(self, *arguments, **options):
        """Runs, requires exit 0, and returns stdout. A program that is piped says nothing on stderr."""
        done = self.run_program(*arguments, **options)
        self.assertEqual(done.returncode, 0, f"{arguments}: {done.stderr}")
        return done.stdout

    def succeeds_json(self, *arguments):
        return json.loads(self.succeeds(*arguments, "--json", "-"))

    def fails(self, *arguments, naming=(), status=1, **options):
        """Runs, requires `status`, the one-line error with every text of `naming`, and an untouched folder."""
        before = self.listing()
        done = self.run_program(*arguments, **options)
        self.assertEqual(done.returncode, status, f"{arguments}: stdout {done.stdout!r} stderr {done.stderr!r}")
        lines = done.stderr.splitlines()
        self.assertEqual(len(lines), 1, f"{arguments}: one line expected: {done.stderr!r}")
        self.assertTrue(lines[0].startswith("annulus: "), lines[0])
        self.assertGreaterEqual(lines[0].count(": "), 3, f"attempted: seen: to do expected: {lines[0]}")
        for text in naming:
            self.assertIn(text, lines[0])
        self.assertEqual(self.listing(), before, f"{arguments} left something behind")
        return lines[0]

    def listing(self):
        """Every file below the test's folder with the hash of its bytes."""
        found = {}
        for path, _, names in os.walk(self.folder):
            for name in names:
                with open(os.path.join(path, name), "rb") as f:
                    found[os.path.relpath(os.path.join(path, name), self.folder)] = hashlib.sha256(f.read()).hexdigest()
        return found

    def import_cylinder(self, cylinder, **options):
        """A recording `scan.mcap` of the cylinder."""
        self.write("cylinder.csv", cylinder.csv(**options))
        self.succeeds("import", "cylinder.csv", "--out", "scan.mcap")
        return "scan.mcap"


def main():
    ProgramTest.program = take_program()
    unittest.main(verbosity=2)
