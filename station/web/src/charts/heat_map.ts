// What a heat map shows: a window of a matrix (for example sensors × levels) as pixels.
import { type ColourTable, colourOf, shareOf } from './colour_map';
import type { Range } from './scale';

export interface Matrix {
  rows: number;
  columns: number;
  /** Row by row; not a number where nothing came back. */
  values: ArrayLike<number>;
}

/** Cells from … to (not included) that a pixel covers; none: from = to. */
export type Span = readonly [from: number, to: number];

/** Cells of one side under each pixel, when a window in cells is shown; each covers at least one. */
export function cellSpans(window: Range, pixels: number, count: number): Span[] {
  const width = window.high - window.low;
  return Array.from({ length: pixels }, (_, k) => {
    const from = Math.min(count - 1, Math.max(0, Math.floor(window.low + (width * k) / pixels)));
    const to = width > pixels ? Math.ceil(window.low + (width * (k + 1)) / pixels - 1e-9) : from + 1;
    return [from, Math.min(count, Math.max(from + 1, to))] as const;
  });
}

/**
 * The same when the cells have times: a cell is shown from its time until the next one's, but not longer than `hold`,
 * so that a pause is a gap.
 */
export function timedSpans(times: ArrayLike<number>, window: Range, pixels: number, hold: number): Span[] {
  const width = window.high - window.low;
  let first = 0;
  return Array.from({ length: pixels }, (_, k) => {
    const from = window.low + (width * k) / pixels;
    const to = window.low + (width * (k + 1)) / pixels;
    while (first + 1 < times.length && times[first + 1]! <= from) ++first;
    let end = first;
    while (end < times.length && times[end]! < to) ++end;
    const stale = times[first]! + hold <= from;
    const begin = stale ? first + 1 : first;
    return [Math.min(begin, end), end] as const;
  });
}

export interface HeatColours {
  table: ColourTable;
  range: Range;
  /** Where nothing came back. */
  empty: readonly [number, number, number];
}

/**
 * RGBA, one pixel per pair of spans. A pixel that covers several cells shows the mean of what is there, so that a line
 * of one cell does not vanish between pixels by chance. Pixels without cells are transparent.
 */
export function rasterised(matrix: Matrix, rows: readonly Span[], columns: readonly Span[], colours: HeatColours): Uint8ClampedArray<ArrayBuffer> {
  const pixels = new Uint8ClampedArray(4 * rows.length * columns.length);
  let at = 0;
  for (const row of rows) {
    for (const column of columns) {
      if (row[0] < row[1] && column[0] < column[1]) {
        const value = meanOf(matrix, row, column);
        const { table, range, empty } = colours;
        pixels.set(Number.isNaN(value) ? empty : colourOf(table, shareOf(value, range.low, range.high)), at);
        pixels[at + 3] = 255;
      }
      at += 4;
    }
  }
  return pixels;
}

function meanOf(matrix: Matrix, rows: Span, columns: Span): number {
  let sum = 0;
  let count = 0;
  for (let row = rows[0]; row < rows[1]; ++row) {
    for (let column = columns[0]; column < columns[1]; ++column) {
      const value = matrix.values[row * matrix.columns + column]!;
      if (!Number.isFinite(value)) continue;
      sum += value;
      ++count;
    }
  }
  return count === 0 ? NaN : sum / count;
}

/** Rows become columns. */
export function transposed(matrix: Matrix): Matrix {
  const values = new Float32Array(matrix.rows * matrix.columns);
  for (let row = 0; row < matrix.rows; ++row) {
    for (let column = 0; column < matrix.columns; ++column) values[column * matrix.rows + row] = matrix.values[row * matrix.columns + column]!;
  }
  return { rows: matrix.columns, columns: matrix.rows, values };
}
