import { describe, expect, it } from 'vitest';
import type { ColourTable } from './colour_map';
import { cellAt, moved, rasterised, wholeWindow, zoomed } from './heat_map';

const grey: ColourTable = Array.from({ length: 256 }, (_, k) => [k, k, k] as const);
const colours = { table: grey, range: { low: 0, high: 255 }, empty: [1, 2, 3] as const };
const matrix = { rows: 2, columns: 4, values: [0, 10, 20, 30, 40, NaN, 60, 70] };

const reds = (pixels: Uint8ClampedArray): number[] => [...pixels].filter((_, k) => k % 4 === 0);

describe('a heat map as pixels', () => {
  it('shows one cell a pixel where they fit', () => {
    const pixels = rasterised(matrix, wholeWindow(matrix), { width: 4, height: 2 }, colours);
    expect(reds(pixels)).toEqual([0, 10, 20, 30, 40, 1, 60, 70]);
    expect([...pixels.slice(20, 24)]).toEqual([1, 2, 3, 255]);
  });
  it('repeats cells when it is larger', () => {
    const pixels = rasterised(matrix, wholeWindow(matrix), { width: 8, height: 2 }, colours);
    expect(reds(pixels).slice(0, 8)).toEqual([0, 0, 10, 10, 20, 20, 30, 30]);
  });
  it('takes means when it is smaller, of what came back', () => {
    const pixels = rasterised(matrix, wholeWindow(matrix), { width: 2, height: 1 }, colours);
    expect(reds(pixels)).toEqual([Math.round((0 + 10 + 40) / 3), 45]);
  });
  it('shows a window', () => {
    const pixels = rasterised(matrix, { rowFrom: 1, rowTo: 2, columnFrom: 2, columnTo: 4 }, { width: 2, height: 1 }, colours);
    expect(reds(pixels)).toEqual([60, 70]);
  });
});

describe('moving about in it', () => {
  it('zooms about the place under the pointer', () => {
    expect(zoomed(0, 100, 50, 0.5, 100)).toEqual([25, 75]);
    const [from, to] = zoomed(20, 60, 30, 0.5, 100);
    expect((30 - from) / (to - from)).toBeCloseTo((30 - 20) / (60 - 20), 12);
  });
  it('stays within the map and above a few cells', () => {
    expect(zoomed(0, 100, 10, 4, 100)).toEqual([0, 100]);
    expect(zoomed(0, 100, 99, 0.001, 100)[1]).toBeLessThanOrEqual(100);
    const [from, to] = zoomed(0, 100, 99, 0.001, 100);
    expect(to - from).toBe(4);
  });
  it('moves to its edge and no further', () => {
    expect(moved(10, 30, -20, 100)).toEqual([0, 20]);
    expect(moved(10, 30, 500, 100)).toEqual([80, 100]);
  });
  it('knows the cell under the pointer', () => {
    const window = { rowFrom: 10, rowTo: 20, columnFrom: 0, columnTo: 180 };
    expect(cellAt(window, 360, 100, 91, 55)).toEqual({ row: 15, column: 45 });
    expect(cellAt(window, 360, 100, -1, 5)).toBeNull();
  });
});
