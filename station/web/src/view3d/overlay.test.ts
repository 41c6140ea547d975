import { describe, expect, it } from 'vitest';
import { layOut } from './overlay';

type Box = { x: number; y: number; width: number; height: number };

function overlap(a: Box, b: Box): boolean {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

/** Numbers 0 … 1 from a seed (Lehmer's generator), so that a failure can be seen again. */
function random(seed: number): () => number {
  let state = seed;
  return () => (state = (state * 48271) % 2147483647) / 2147483647;
}

describe('labels', () => {
  it('stand beside their places', () => {
    const [box] = layOut([{ x: 100, y: 100, width: 60, height: 20 }], 800, 600);
    expect(box).toEqual({ x: 118, y: 90, width: 60, height: 20 });
  });

  it('go to the other side where there is no room', () => {
    const [box] = layOut([{ x: 780, y: 100, width: 60, height: 20 }], 800, 600);
    expect(box!.x + box!.width).toBeLessThanOrEqual(780);
  });

  it('cover no handle', () => {
    const handle = { x: 120, y: 86, width: 28, height: 28 };
    const [box] = layOut([{ x: 100, y: 100, width: 60, height: 20 }], 800, 600, [handle]);
    expect(overlap(box!, handle)).toBe(false);
  });

  it('never cover each other and stay in the picture, 20 at a time', () => {
    for (let seed = 1; seed <= 50; ++seed) {
      const next = random(seed);
      const anchors = Array.from({ length: 20 }, () => ({ x: 800 * next(), y: 600 * next(), width: 60 + 60 * next(), height: 22 }));
      const boxes = layOut(anchors, 800, 600);
      for (const [i, box] of boxes.entries()) {
        expect(box.y).toBeGreaterThanOrEqual(0);
        expect(box.y + box.height).toBeLessThanOrEqual(600);
        for (const other of boxes.slice(i + 1)) expect(overlap(box, other), `seed ${seed}`).toBe(false);
      }
    }
  });
});
