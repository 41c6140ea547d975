"""A person like a vase: sections are copies of one convex curve 1 + 0.1 cos 2θ, sized by bumps for head, chest and hip.

Its girths have closed forms: size(z) times the perimeter of the unit section.
"""

import math
import random

from annulus_cli import CSV_COLUMNS, RING_RADIUS_MM

UNIT_PERIMETER = 6.3457068653  # scipy.integrate.quad(lambda t: np.hypot(1+.1*np.cos(2*t), -.2*np.sin(2*t)), 0, 2*np.pi)
# Extrema of `size`, by scipy.optimize.minimize_scalar on (1180, 1350), (950, 1230) and (700, 1000): z and size, mm.
LEVELS = {"chest": (1263.205958, 140.786579), "waist": (1093.005775, 88.269275), "hip": (870.033809, 150.003918)}


def size(z):
    def bump(height, middle, width):
        return height * math.exp(-((z - middle) / width) ** 2)
    return 55 + bump(36, 1590, 85) + bump(85, 1265, 125) + bump(95, 870, 180)


def girth(level):
    return UNIT_PERIMETER * LEVELS[level][1]


def csv(seed=1, noise=0.3, stretch=1.0, z_min=500, z_max=1690, pitch=10):
    """A noisy scan from the top down; `stretch` enlarges the whole body sideways."""
    rng = random.Random(seed)
    lines = [f"# vase; R_mm={RING_RADIUS_MM:g}; theta_deg=2*sensor", CSV_COLUMNS]
    for level in range(int((z_max - z_min) / pitch) + 1):
        z = z_max - level * pitch
        for sensor in range(180):
            theta = math.radians(2 * sensor)
            radius = stretch * size(z) * (1 + 0.1 * math.cos(2 * theta))
            lines.append(f"{level},{z:.3f},{sensor},{2 * sensor},{RING_RADIUS_MM - radius + rng.gauss(0, noise):.4f}")
    return "\n".join(lines) + "\n"
