import { describe, expect, it } from 'vitest';
import type { ColourTable } from './colour_map';
import { cellSpans, rasterised, timedSpans, transposed } from './heat_map';

const grey: ColourTable = Array.from({ length: 256 }, (_, k) => [k, k, k] as const);
const colours = { table: grey, range: { low: 0, high: 255 }, empty: [1, 2, 3] as const };
const matrix = { rows: 2, columns: 4, values: [0, 10, 20, 30, 40, NaN, 60, 70] };

const reds = (pixels: Uint8ClampedArray): number[] => [...pixels].filter((_, k) => k % 4 === 0);
const shown = (width: number, height: number): Uint8ClampedArray =>
  rasterised(matrix, cellSpans({ low: 0, high: 2 }, height, 2), cellSpans({ low: 0, high: 4 }, width, 4), colours);

describe('a heat map as pixels', () => {
  it('shows one cell a pixel where they fit', () => {
    expect(reds(shown(4, 2))).toEqual([0, 10, 20, 30, 40, 1, 60, 70]);
    expect([...shown(4, 2).slice(20, 24)]).toEqual([1, 2, 3, 255]);
  });
  it('repeats cells when it is larger', () => expect(reds(shown(8, 2)).slice(0, 8)).toEqual([0, 0, 10, 10, 20, 20, 30, 30]));
  it('takes means when it is smaller, of what came back', () => {
    expect(reds(shown(2, 1))).toEqual([Math.round((0 + 10 + 40) / 3), 45]);
  });
  it('shows a window', () => {
    const pixels = rasterised(matrix, cellSpans({ low: 1, high: 2 }, 1, 2), cellSpans({ low: 2, high: 4 }, 2, 4), colours);
    expect(reds(pixels)).toEqual([60, 70]);
  });
  it('lets the ground through where there are no cells', () => {
    const pixels = rasterised(matrix, [[0, 1]], [[0, 0], [1, 2]], colours);
    expect([...pixels]).toEqual([0, 0, 0, 0, 10, 10, 10, 255]);
  });
});

describe('cells with times', () => {
  it('are shown until the next one comes', () => {
    expect(timedSpans([0, 1, 2], { low: 0, high: 3 }, 6, 10)).toEqual([[0, 1], [0, 1], [1, 2], [1, 2], [2, 3], [2, 3]]);
  });
  it('leave a gap where there is a pause', () => {
    expect(timedSpans([0, 1, 5], { low: 0, high: 6 }, 6, 1)).toEqual([[0, 1], [1, 2], [2, 2], [2, 2], [2, 2], [2, 3]]);
  });
  it('share a pixel where there are many', () => {
    expect(timedSpans([0, 0.5, 1, 1.5], { low: 0, high: 2 }, 1, 0.5)).toEqual([[0, 4]]);
  });
  it('are not there before the first', () => {
    expect(timedSpans([2], { low: 0, high: 4 }, 4, 1).map(([from, to]) => to - from)).toEqual([0, 0, 1, 0]);
  });
});

it('rows become columns', () => {
  const turned = transposed({ rows: 2, columns: 3, values: [1, 2, 3, 4, 5, 6] });
  expect([turned.rows, turned.columns, ...turned.values as Float32Array]).toEqual([3, 2, 1, 4, 2, 5, 3, 6]);
});
