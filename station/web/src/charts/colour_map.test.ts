import { describe, expect, it } from 'vitest';
import { colourOf, diverging, divergingLab, oklabDistance, sequential, sequentialLab, shareOf, steps } from './colour_map';

const stepsOf = (lab: readonly (readonly [number, number, number])[]): number[] =>
  lab.slice(1).map((one, k) => oklabDistance(lab[k]!, one));

// WCAG 2.2, "relative luminance".
function luminance(rgb: readonly number[]): number {
  const [r, g, b] = rgb.map((c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
}

describe('the colour map for values from little to much', () => {
  it('has equal steps of colour for equal steps of the value', () => {
    const all = stepsOf(sequentialLab);
    const mean = all.reduce((sum, one) => sum + one, 0) / all.length;
    for (const step of all) expect(Math.abs(step - mean) / mean).toBeLessThan(0.02);
  });
  it('becomes lighter with every step, so that it reads in grey, too', () => {
    for (let k = 1; k < steps; ++k) expect(sequentialLab[k]![0]).toBeGreaterThan(sequentialLab[k - 1]![0]);
    for (let k = 8; k < steps; k += 8) expect(luminance(sequential[k]!)).toBeGreaterThan(luminance(sequential[k - 8]!));
  });
  it('is made of colours that a screen has', () => {
    for (const rgb of sequential) for (const channel of rgb) expect(channel).toBeGreaterThanOrEqual(0);
    expect(sequential).toHaveLength(256);
    expect(luminance(sequential[0]!)).toBeLessThan(0.03);
    expect(luminance(sequential[255]!)).toBeGreaterThan(0.75);
  });
});

describe('the colour map about zero', () => {
  it.each(['light', 'dark'] as const)('has equal steps on both sides of a %s middle', (ground) => {
    const lab = divergingLab(ground);
    for (const half of [lab.slice(0, 128), lab.slice(128)]) {
      const all = stepsOf(half);
      const mean = all.reduce((sum, one) => sum + one, 0) / all.length;
      for (const step of all) expect(Math.abs(step - mean) / mean).toBeLessThan(0.02);
    }
    expect(oklabDistance(lab[127]!, lab[128]!)).toBeLessThan(0.01);
  });
  it('is bluish below and reddish above', () => {
    for (const table of [diverging.light, diverging.dark]) {
      const [low, high] = [table[10]!, table[245]!];
      expect(low[2]).toBeGreaterThan(low[0]);
      expect(high[0]).toBeGreaterThan(high[2]);
    }
  });
});

describe('looking a colour up', () => {
  it('clips what is beyond the ends', () => {
    expect(shareOf(-5, 0, 10)).toBe(0);
    expect(shareOf(2.5, 0, 10)).toBe(0.25);
    expect(shareOf(99, 0, 10)).toBe(1);
    expect(colourOf(sequential, 1)).toBe(sequential[255]);
    expect(colourOf(sequential, 0)).toBe(sequential[0]);
  });
  it('has a middle for a scale without width', () => expect(shareOf(3, 3, 3)).toBe(0.5));
});
