import { describe, expect, it } from 'vitest';
import { pointOf, RingSurface, veiled, type LevelRing } from './ring_surface';

const ring = (radius: number | null, z_mm = 0, columns = 180, sweep = 0): LevelRing => ({
  sweep,
  level: 0,
  z_mm,
  sensor_step: 180 / columns,
  radius_mm: new Array<number | null>(columns).fill(radius),
});

describe('a ring of one radius', () => {
  it('has its points at that radius and height', () => {
    const level = ring(250, 900);
    for (let k = 0; k < 180; k += 1) {
      const [x, y, z] = pointOf(level, k) ?? [0, 0, 0];
      expect(Math.hypot(x, y)).toBeCloseTo(250, 9);
      expect(z).toBe(900);
    }
  });
  it('has reading 45 in front, on +y', () => {
    const [x, y] = pointOf(ring(250), 45) ?? [0, 0];
    expect(x).toBeCloseTo(0, 9);
    expect(y).toBeCloseTo(250, 9);
  });
  it('has the same places with every third sensor', () => {
    expect(pointOf(ring(250, 0, 60), 15)?.[1]).toBeCloseTo(250, 9);
  });
});

describe('the surface of a cylinder', () => {
  const surface = new RingSurface(180, 10);
  for (let n = 0; n < 10; n += 1) surface.add(ring(200, 5 * n));
  it('has two triangles for each pair of readings and levels', () => {
    expect(surface.indices).toBe(9 * 180 * 6);
  });
  it('has the area of a cylinder with a base of 180 corners', () => {
    // 180 corners at radius r: the girth is 180 · 2 r sin(1°).
    const girth = 180 * 2 * 200 * Math.sin(Math.PI / 180);
    expect(areaOf(surface)).toBeCloseTo(girth * 45, 2);
  });
  it('has normals that point away from the axis', () => {
    for (let k = 0; k < surface.vertices; k += 1) {
      const x = surface.positions[3 * k] ?? 0;
      const y = surface.positions[3 * k + 1] ?? 0;
      const dot = (x * (surface.normals[3 * k] ?? 0) + y * (surface.normals[3 * k + 1] ?? 0)) / 200;
      expect(dot).toBeCloseTo(1, 5);
    }
  });
  it('takes no more rings than it has room for', () => {
    expect(surface.add(ring(200, 60))).toBe(false);
  });
});

describe('triangles', () => {
  it('are counter-clockwise from outside, whether the ring goes up or down', () => {
    for (const heights of [[0, 5], [5, 0]]) {
      const surface = new RingSurface(180, 2);
      for (const z_mm of heights) surface.add(ring(200, z_mm));
      for (let k = 0; k < surface.indices; k += 3) {
        const [a, b, c] = [0, 1, 2].map((corner) => cornerOf(surface, surface.triangles[k + corner] ?? 0)) as [number[], number[], number[]];
        const [ux, uy, uz, vx, vy, vz] = [0, 1, 2].map((axis) => (b[axis] ?? 0) - (a[axis] ?? 0)).concat([0, 1, 2].map((axis) => (c[axis] ?? 0) - (a[axis] ?? 0))) as [number, number, number, number, number, number];
        const outwards = (uy * vz - uz * vy) * (a[0] ?? 0) + (uz * vx - ux * vz) * (a[1] ?? 0);
        expect(outwards).toBeGreaterThan(0);
      }
    }
  });
});

describe('what is not joined', () => {
  it('are levels of two sweeps, levels far apart, and readings that saw nothing', () => {
    for (const second of [ring(200, 5, 180, 1), ring(200, 100), ring(null, 5)]) {
      const surface = new RingSurface(180, 2);
      surface.add(ring(200, 0));
      surface.add(second);
      expect(surface.indices).toBe(0);
    }
  });
  it('are neighbours of different parts', () => {
    const two = ring(150, 0);
    const radius_mm = two.radius_mm.map((radius, k) => (k < 90 ? radius : 400));
    const surface = new RingSurface(180, 2);
    surface.add({ ...two, radius_mm });
    surface.add({ ...two, radius_mm, z_mm: 5 });
    expect(surface.indices).toBe(6 * 178);
  });
});

describe('the veil', () => {
  it('leaves a circle a circle, with a third of its points', () => {
    const soft = veiled(ring(250));
    expect(soft.radius_mm).toHaveLength(60);
    expect(soft.sensor_step).toBe(3);
    for (const radius of soft.radius_mm) expect(radius).toBeCloseTo(250, 9);
  });
  it('takes away what is finer than its window', () => {
    const level = ring(250);
    const radius_mm = level.radius_mm.map((radius, k) => (radius ?? 0) + 20 * Math.cos((12 * 2 * k * Math.PI) / 180));
    const soft = veiled({ ...level, radius_mm });
    for (const radius of soft.radius_mm) expect(Math.abs((radius ?? 0) - 250)).toBeLessThan(5);
  });
  it('shows nothing where nothing was seen', () => {
    expect(veiled(ring(null)).radius_mm.every((radius) => radius === null)).toBe(true);
  });
});

function cornerOf(surface: RingSurface, index: number): number[] {
  return [0, 1, 2].map((axis) => surface.positions[3 * index + axis] ?? 0);
}

function areaOf(surface: RingSurface): number {
  let area = 0;
  for (let k = 0; k < surface.indices; k += 3) {
    const [a, b, c] = [0, 1, 2].map((corner) => cornerOf(surface, surface.triangles[k + corner] ?? 0)) as [number[], number[], number[]];
    const u = b.map((value, axis) => value - (a[axis] ?? 0)) as [number, number, number];
    const v = c.map((value, axis) => value - (a[axis] ?? 0)) as [number, number, number];
    area += Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
  }
  return area;
}
