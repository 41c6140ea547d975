"""Expected values of lens_trace_test.cpp and lens_surface_test.cpp, by another way: 40-digit arithmetic, surfaces as
implicit equations, rays met by root finding, power from finite differences of a bundle of rays (no Coddington).

Run: python3 tests/modeling_lens/lens_reference.py (needs mpmath). Prints one line per number.
"""
from mpmath import mp, mpf, matrix, sqrt, sin, cos, radians, findroot, tan

mp.dps = 40


def rotation(axis, degrees):
    """About x (0), y (1) or z (2), right-handed."""
    c, s = cos(radians(mpf(degrees))), sin(radians(mpf(degrees)))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    r = mp.eye(3)
    r[i, i] = r[j, j] = c
    r[i, j], r[j, i] = -s, s
    return r


def vec(*v):
    return matrix([mpf(x) for x in v])


def dot(a, b):
    return sum(a[i] * b[i] for i in range(3))


def unit(a):
    return a / sqrt(dot(a, a))


class Surface:
    """Torus: circle of radius ra in the u-w plane turned about the line parallel to u at w = -rb (sphere if equal)."""

    def __init__(self, vertex, turn, ra, rb):
        self.vertex, self.turn, self.ra, self.rb = vertex, turn, mpf(ra), mpf(rb)

    def value(self, p):
        u, v, w = self.turn.T * (p - self.vertex)
        rho = sqrt(v * v + (w + self.rb) ** 2)
        return (rho - (self.rb - self.ra)) ** 2 + u * u - self.ra ** 2

    def normal(self, p):
        u, v, w = self.turn.T * (p - self.vertex)
        rho = sqrt(v * v + (w + self.rb) ** 2)
        k = rho - (self.rb - self.ra)
        n = unit(self.turn * vec(u, k * v / rho, k * (w + self.rb) / rho))
        return n if n[2] > 0 else -n

    def meet(self, origin, direction):
        plane = -dot(origin - self.vertex, self.turn[:, 2]) / dot(direction, self.turn[:, 2])
        t = findroot(lambda t: self.value(origin + t * direction), (plane, plane + mpf("0.01")), tol=mpf(10) ** -60)
        return origin + t * direction


def refract(d, n, ratio):
    c = dot(d, n)
    root = sqrt(1 - ratio ** 2 * (1 - c * c))
    return ratio * d + ((root if c > 0 else -root) - ratio * c) * n


N = mpf("1.6")
FRONT = Surface(vec(0, 0, 0), mp.eye(3), 120, 120)
# The back's normal leans by 2 degrees towards 200 degrees; its steep meridian is at 30 degrees.
LEAN = rotation(2, 200) * rotation(1, 2) * rotation(2, -200)
BACK = Surface(vec(0, 0, "-2.2"), LEAN * rotation(2, 30), 55, 70)
LENS_FROM_VIEW = (rotation(0, 10) * rotation(1, -6)).T  # pantoscopic 10, face form 6 degrees, right eye
VERTEX, CENTRE = mpf(13), mpf(13)


def outwards(origin, direction):
    """From the eye into the object space."""
    back = BACK.meet(origin, direction)
    glass = refract(direction, BACK.normal(back), 1 / N)
    front = FRONT.meet(back, glass)
    return back, front, refract(glass, FRONT.normal(front), N)


def inwards(origin, direction):
    """From the object into the eye."""
    front = FRONT.meet(origin, direction)
    glass = refract(direction, FRONT.normal(front), 1 / N)
    back = BACK.meet(front, glass)
    return back, refract(glass, BACK.normal(back), N)


def trace(name, left, up):
    left, up = radians(mpf(left)), radians(mpf(up))
    looking = vec(sin(left) * cos(up), sin(up), cos(left) * cos(up))
    # Listing: the shortest turn from z to the gaze, by Rodrigues' formula.
    axis = vec(-looking[1], looking[0], 0)
    turn = mp.eye(3)
    if dot(axis, axis) > 0:
        k = matrix([[0, 0, axis[1]], [0, 0, -axis[0]], [-axis[1], axis[0], 0]])
        turn = mp.eye(3) + k + k * k / (1 + looking[2])
    axes = LENS_FROM_VIEW * turn
    ex, ey, ez = axes[:, 0], axes[:, 1], axes[:, 2]
    centre = BACK.vertex - (VERTEX + CENTRE) * LENS_FROM_VIEW[:, 2]
    back, front, outside = outwards(centre, ez)
    print(f"{name} prism", mp.nstr(100 * dot(outside, ex) / dot(outside, ez), 15),
          mp.nstr(100 * dot(outside, ey) / dot(outside, ez), 15))
    # The bundle: parallel rays beside the chief ray; slopes against places where they cross the plane that touches the
    # vertex sphere.
    h = mpf(10) ** -12
    plane = centre + (VERTEX + CENTRE) * ez
    sideways = [unit(ex - dot(ex, outside) * outside), None]
    sideways[1] = unit(ey - dot(ey, outside) * outside)
    places, slopes = mp.zeros(2, 2), mp.zeros(2, 2)
    for column, side in enumerate(sideways):
        values = []
        for sign in (1, -1):
            point, direction = inwards(front + sign * h * side, -outside)
            s = dot(plane - point, ez) / dot(direction, ez)
            at = point + s * direction - plane
            run = -dot(direction, ez)
            values.append((dot(at, ex), dot(at, ey), dot(direction, ex) / run, dot(direction, ey) / run))
        a, b = values
        for row in range(2):
            places[row, column] = (a[row] - b[row]) / (2 * h)
            slopes[row, column] = (a[row + 2] - b[row + 2]) / (2 * h)
    power = -1000 * slopes * places ** -1
    print(f"{name} power", *(mp.nstr(power[i, j], 15) for i, j in ((0, 0), (0, 1), (1, 0), (1, 1))))


trace("straight", 0, 0)
trace("gaze 15 left 20 down", 15, -20)
trace("gaze 25 right 10 up", -25, 10)
for x, y in ((0, 0), (12, 5), (-20, 11), (25, -18)):
    top = vec(x, y, 0)
    down = vec(0, 0, -1)
    front, back = FRONT.meet(top, down), BACK.meet(top, down)
    print(f"sag at {x} {y}", mp.nstr(front[2], 15), mp.nstr(back[2], 15))
