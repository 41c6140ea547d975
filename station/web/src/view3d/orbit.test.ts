import { describe, expect, it } from 'vitest';
import { between, eyeOf, farthest_mm, keyed, nearest_mm, shifted, turned, zoomed, type CameraPlace } from './orbit';

const front: CameraPlace = { azimuth_deg: 90, elevation_deg: 0, distance_mm: 1000, target: [0, 0, 1500] };

describe('the camera', () => {
  it('stands before the body at 90 degrees', () => {
    const [x, y, z] = eyeOf(front);
    expect(x).toBeCloseTo(0, 9);
    expect(y).toBeCloseTo(1000, 9);
    expect(z).toBeCloseTo(1500, 9);
  });

  it('stands at the subject’s left at 135 degrees: −x, +y', () => {
    const [x, y] = eyeOf(keyed(front, '2')!);
    expect(x).toBeCloseTo(-Math.SQRT1_2 * 1000, 6);
    expect(y).toBeCloseTo(Math.SQRT1_2 * 1000, 6);
  });

  it('turns round and round', () => {
    expect(turned(front, 300, 0).azimuth_deg).toBe(30);
    expect(turned(front, -100, 0).azimuth_deg).toBe(350);
  });

  it('never goes over the pole', () => {
    expect(turned(front, 0, 200).elevation_deg).toBe(89);
    expect(turned(front, 0, -200).elevation_deg).toBe(-89);
  });

  it('keeps its distance within limits', () => {
    expect(zoomed(front, 1e-9).distance_mm).toBe(nearest_mm);
    expect(zoomed(front, 1e9).distance_mm).toBe(farthest_mm);
  });

  it('shifts across the picture: seen from the front, right is −x', () => {
    const [x, y, z] = shifted(front, 10, 5).target;
    expect(x).toBeCloseTo(-10, 9);
    expect(y).toBeCloseTo(0, 9);
    expect(z).toBeCloseTo(1505, 9);
  });

  it('glides the short way round', () => {
    const half = between({ ...front, azimuth_deg: 350 }, { ...front, azimuth_deg: 30 }, 0.5);
    expect(half.azimuth_deg).toBeCloseTo(10, 9);
  });

  it('leaves keys alone that are not its own', () => {
    for (const key of ['Escape', ' ', 'Tab', 'a', '9']) expect(keyed(front, key)).toBeNull();
  });
});
