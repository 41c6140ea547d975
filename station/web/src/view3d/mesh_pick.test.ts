import { describe, expect, it } from 'vitest';
import type { StationMesh } from './mesh_format';
import { pickMesh, type Vec3 } from './mesh_pick';

/** Two squares of 200 mm across the y axis, at y = 100 and y = −100, both seen from the front. */
function sheets(): StationMesh {
  const square = (y: number): number[] => [-100, y, -100, 100, y, -100, 100, y, 100, -100, y, 100];
  return {
    positions: new Float32Array([...square(100), ...square(-100)]),
    normals: new Float32Array(new Array(8).fill([0, 1, 0]).flat()),
    knowledge: new Uint8Array([0, 1, 0, 0, 2, 2, 2, 2]),
    indices: new Uint32Array([0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7]),
    parts: [],
  };
}

describe('pickMesh', () => {
  it('finds the nearest sheet, where the ray meets it', () => {
    const hit = pickMesh(sheets(), { origin: [10, 500, 20], direction: [0, -1, 0] });
    expect(hit?.point).toEqual([10, 100, 20]);
    expect(hit?.normal).toEqual([0, 1, 0]);
    expect(hit?.distance).toBeCloseTo(400, 9);
  });

  it('finds what lies in front of the origin only', () => {
    expect(pickMesh(sheets(), { origin: [0, 0, 0], direction: [0, -1, 0] })?.point[1]).toBe(-100);
  });

  it('finds nothing beside the sheets', () => {
    expect(pickMesh(sheets(), { origin: [101, 500, 0], direction: [0, -1, 0] })).toBeNull();
  });

  it('says what is known at the nearest corner', () => {
    expect(pickMesh(sheets(), { origin: [99, 500, -99], direction: [0, -1, 0] })?.knowledge).toBe(1);
  });

  it('meets a slanted ray where the plane equation says', () => {
    // From (0, 300, 0) along (1, −4, 2)/√21: y = 100 after t = 200·√21/4, at x = 50, z = 100 · 1.
    const length = Math.sqrt(21);
    const direction: Vec3 = [1 / length, -4 / length, 2 / length];
    const hit = pickMesh(sheets(), { origin: [0, 300, -50], direction });
    expect(hit?.point[0]).toBeCloseTo(50, 6);
    expect(hit?.point[1]).toBeCloseTo(100, 6);
    expect(hit?.point[2]).toBeCloseTo(50, 6);
  });
});
