import { describe, expect, it } from 'vitest';
import { LiveRing } from './live_ring';

const level = (radius_mm: (number | null)[], k = 0, sensor_step = 1) => ({ sweep: 0, level: k, time_ns: 0, sent_ms: 1000, z_mm: 1500 - k, sensor_step, radius_mm });

describe('a running ring', () => {
  it('keeps the newest radius of every sensor that was told', () => {
    const ring = new LiveRing();
    ring.take(level([300, null, 310], 0, 60), 1040);
    expect(ring.radius[0]).toBe(300);
    expect(ring.radius[60]).toBeNull();
    expect(ring.radius[1]).toBeUndefined();
    expect(ring.delayMs).toBe(40);
    expect(ring.zMm).toBe(1500);
  });
  it('counts what did not come back among the last sixteen levels', () => {
    const ring = new LiveRing();
    for (let k = 0; k < 40; ++k) ring.take(level([k < 24 ? null : k % 4 === 0 ? null : 300], k), 0);
    expect(ring.noReturnShare(0)).toBe(0.25);
    expect(ring.noReturnShare(1)).toBeNaN();
  });
});

describe('the scatter of a sensor', () => {
  it('is zero on a straight slope', () => {
    const ring = new LiveRing();
    for (let k = 0; k < 16; ++k) ring.take(level([300 + 2.5 * k], k), 0);
    expect(ring.scatter(0)).toBeCloseTo(0, 9);
  });
  it('is the sd of the readings', () => {
    // Normal numbers of sd 0.5 by Box and Muller, seed 7 (Park and Miller); mean over sensors, since one has few levels.
    let seed = 7;
    const uniform = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
    const normal = () => Math.sqrt(-2 * Math.log(uniform())) * Math.cos(2 * Math.PI * uniform());
    const ring = new LiveRing();
    for (let k = 0; k < 16; ++k) ring.take(level(Array.from({ length: 180 }, () => 300 + 0.5 * normal()), k), 0);
    const all = Array.from({ length: 180 }, (_, sensor) => ring.scatter(sensor));
    expect(all.reduce((sum, one) => sum + one, 0) / 180).toBeGreaterThan(0.43);
    expect(all.reduce((sum, one) => sum + one, 0) / 180).toBeLessThan(0.57);
  });
  it('is not known from few levels', () => {
    const ring = new LiveRing();
    for (let k = 0; k < 6; ++k) ring.take(level([300], k), 0);
    expect(ring.scatter(0)).toBeNaN();
  });
});
