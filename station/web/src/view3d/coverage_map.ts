// What was seen so far, unrolled: the angle around the body across, height up. A cell is one reading of one level.
import { h } from '../core/dom';
import type { LevelRing } from './ring_surface';

const kRows = 220;
const kColumns = 180;

export class CoverageMap {
  readonly element: HTMLCanvasElement;
  readonly #context: CanvasRenderingContext2D | null;
  readonly #range: { low_mm: number; high_mm: number };
  #lastRow: { sweep: number; row: number } | null = null;
  #seen = 0;
  #asked = 0;

  /** @param label for those who do not see it. */
  constructor(label: string, range: { low_mm: number; high_mm: number }) {
    this.element = h('canvas', { class: 'coverage', width: kColumns, height: kRows, role: 'img', 'aria-label': label });
    this.#context = this.element.getContext('2d');
    this.#range = range;
  }

  /** Share of the directions that saw something, of all levels so far, 0 … 1. */
  get share(): number {
    return this.#asked === 0 ? 0 : this.#seen / this.#asked;
  }

  add(level: LevelRing): void {
    const row = this.#rowOf(level.z_mm);
    const from = this.#lastRow && this.#lastRow.sweep === level.sweep ? Math.min(this.#lastRow.row, row) : row;
    const to = this.#lastRow && this.#lastRow.sweep === level.sweep ? Math.max(this.#lastRow.row, row) : row;
    this.#lastRow = { sweep: level.sweep, row };
    const colours = getComputedStyle(this.element);
    const width = kColumns / level.radius_mm.length;
    for (const [k, radius] of level.radius_mm.entries()) {
      this.#asked += 1;
      if (radius !== null) this.#seen += 1;
      if (!this.#context) continue;
      this.#context.fillStyle = colours.getPropertyValue(radius === null ? '--coverage-none' : '--coverage-seen').trim() || '#888';
      // Direction 270° (the back) at both edges, the front in the middle.
      const x = (k * width + kColumns / 4) % kColumns;
      this.#context.fillRect(kColumns - x - width, from, width, to - from + 1);
    }
  }

  #rowOf(z_mm: number): number {
    const share = (this.#range.high_mm - z_mm) / (this.#range.high_mm - this.#range.low_mm);
    return Math.min(Math.max(Math.round(share * (kRows - 1)), 0), kRows - 1);
  }
}
