import { describe, expect, it } from 'vitest';
import { rimCentreLine } from './frame_drawing';

// Paper 000, §3.3: M0, M3, M6, M9 lie on the bisectors of the rectangle's corners at distance t; M11 M0 M1, M2 M3 M4,
// M5 M6 M7 and M8 M9 M10 are straight, and M1 M2 and M8 M7 lie on the upper and lower side.
const corners = { 'upper-outer': 6, 'upper-inner': 4, 'lower-outer': 9, 'lower-inner': 2 };
const points = rimCentreLine({ width: 50, height: 40, ...corners });
const place = (i: number): { x: number; y: number } => points[i % 12]!;

describe('the rim’s centre line', () => {
  it('has its corners on the bisectors, t from the rectangle’s', () => {
    const rectangle = [[0, 40, 6], [50, 40, 4], [50, 0, 2], [0, 0, 9]] as const;
    rectangle.forEach(([x, y, t], i) => {
      const m = place(3 * i);
      expect(Math.hypot(m.x - x, m.y - y)).toBeCloseTo(t, 9);
      expect(Math.abs(m.x - x)).toBeCloseTo(Math.abs(m.y - y), 9);
    });
  });

  it('is straight at its corners, so that the four curves join smoothly', () => {
    for (const i of [0, 3, 6, 9]) {
      const [before, at, after] = [place(i + 11), place(i), place(i + 1)];
      const cross = (at.x - before.x) * (after.y - at.y) - (at.y - before.y) * (after.x - at.x);
      expect(cross).toBeCloseTo(0, 9);
    }
  });

  it('runs along the sides of the rectangle', () => {
    expect(place(1).y).toBeCloseTo(40, 9);
    expect(place(2).y).toBeCloseTo(40, 9);
    expect(place(4).x).toBeCloseTo(50, 9);
    expect(place(7).y).toBeCloseTo(0, 9);
  });

  it('is a circle of 0.911·l1/2 for the roundest cut of a square (example 2)', () => {
    const round = rimCentreLine({ width: 50, height: 50, 'upper-outer': 12.58, 'upper-inner': 12.58, 'lower-outer': 12.58, 'lower-inner': 12.58 });
    for (let i = 0; i < 12; i += 3) {
      const [a, b, c, d] = [0, 1, 2, 3].map((k) => round[(i + k) % 12]!) as [typeof round[0], typeof round[0], typeof round[0], typeof round[0]];
      for (const u of [0, 0.25, 0.5, 0.75]) {
        const weights = [(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u ** 2 * (1 - u), u ** 3];
        const at = (axis: 'x' | 'y'): number => weights[0]! * a[axis] + weights[1]! * b[axis] + weights[2]! * c[axis] + weights[3]! * d[axis];
        expect(Math.hypot(at('x') - 25, at('y') - 25) / 25).toBeCloseTo(0.911, 2);
      }
    }
  });
});
