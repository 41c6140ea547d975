// What a heat map shows: a window of a matrix (rows of levels or scans × columns of sensors) as pixels.
import { type ColourTable, colourOf, shareOf } from './colour_map';
import type { Range } from './scale';

export interface Matrix {
  rows: number;
  columns: number;
  /** Row by row; not a number where nothing came back. */
  values: ArrayLike<number>;
}

/** Rows and columns that are shown, from … to (not included); broken numbers while somebody zooms. */
export interface MapWindow {
  rowFrom: number;
  rowTo: number;
  columnFrom: number;
  columnTo: number;
}

export function wholeWindow(matrix: Matrix): MapWindow {
  return { rowFrom: 0, rowTo: matrix.rows, columnFrom: 0, columnTo: matrix.columns };
}

/** One axis zoomed by `factor` (below 1: nearer) about `anchor`, within 0 … count and not below `least` cells. */
export function zoomed(from: number, to: number, anchor: number, factor: number, count: number, least = 4): [number, number] {
  const width = Math.min(count, Math.max(Math.min(least, count), (to - from) * factor));
  const share = to > from ? (anchor - from) / (to - from) : 0.5;
  const start = Math.min(Math.max(0, anchor - share * width), count - width);
  return [start, start + width];
}

/** One axis moved by `by` cells, within 0 … count. */
export function moved(from: number, to: number, by: number, count: number): [number, number] {
  const shift = Math.min(Math.max(by, -from), count - to);
  return [from + shift, to + shift];
}

/** The cell at a place of a picture of width × height pixels, null outside. */
export function cellAt(window: MapWindow, width: number, height: number, x: number, y: number): { row: number; column: number } | null {
  if (x < 0 || y < 0 || x >= width || y >= height) return null;
  return {
    row: Math.floor(window.rowFrom + (y / height) * (window.rowTo - window.rowFrom)),
    column: Math.floor(window.columnFrom + (x / width) * (window.columnTo - window.columnFrom)),
  };
}

/**
 * The window as RGBA. A pixel that covers several cells shows the mean of what is there, so that a line of one cell
 * does not vanish between pixels by chance; a pixel whose cells are all empty is `empty`.
 */
export function rasterised(
  matrix: Matrix,
  window: MapWindow,
  size: { width: number; height: number },
  colours: { table: ColourTable; range: Range; empty: readonly [number, number, number] },
): Uint8ClampedArray<ArrayBuffer> {
  const { width, height } = size;
  const pixels = new Uint8ClampedArray(4 * width * height);
  const columns = edges(window.columnFrom, window.columnTo, width, matrix.columns);
  const rows = edges(window.rowFrom, window.rowTo, height, matrix.rows);
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const value = meanOf(matrix, rows[y]!, columns[x]!);
      const { table, range, empty } = colours;
      const colour = Number.isNaN(value) ? empty : colourOf(table, shareOf(value, range.low, range.high));
      pixels.set(colour, 4 * (y * width + x));
      pixels[4 * (y * width + x) + 3] = 255;
    }
  }
  return pixels;
}

type Span = readonly [from: number, to: number];

/** Which cells each pixel covers, at least one. */
function edges(from: number, to: number, pixels: number, count: number): Span[] {
  return Array.from({ length: pixels }, (_, k) => {
    const first = Math.min(count - 1, Math.max(0, Math.floor(from + ((to - from) * k) / pixels)));
    const end = Math.ceil(from + ((to - from) * (k + 1)) / pixels - 1e-9);
    return [first, Math.min(count, Math.max(first + 1, (to - from) > pixels ? end : first + 1))] as const;
  });
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
