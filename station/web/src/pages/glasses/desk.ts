// The designer's state: the bench with its history, what the server says about it, and who is told.
import { Signal } from '../../core/signal';
import type { Catalogue, FieldValues, FitReport, GlassesApi, PreviewNotes, Style } from './api';
import { firstLook, withDesign, type Bench, type Design } from './design';
import { History } from './history';
import type { Prescription } from './prescription';

export type Side = 'a' | 'b';

/** A fit that was computed, and for what. */
export interface Fitted {
  design: Design;
  prescription: Prescription | null;
  worn: string;
  report: FitReport;
}

const noNotes: PreviewNotes = { adjusted: [] };

export class Desk {
  readonly bench: Signal<Bench>;
  /** What was adjusted in what is shown. */
  readonly notes = new Signal<Record<Side, PreviewNotes>>({ a: noNotes, b: noNotes });
  readonly fitted = new Signal<Record<Side, Fitted | null>>({ a: null, b: null });
  readonly history: History<Bench>;
  readonly #styles: Map<string, Style>;

  constructor(
    readonly api: GlassesApi,
    readonly catalogue: Catalogue,
    prescription: Prescription | null,
    firstLabel: string,
  ) {
    this.#styles = new Map(catalogue.styles.map((style) => [style.id, style]));
    const style = catalogue.styles.find((one) => one.id === 'soft-square') ?? catalogue.styles[0];
    const bench: Bench = { a: { style: style?.id ?? '', size: '', fields: {}, look: firstLook() }, b: null, active: 'a', prescription };
    this.history = new History({ value: bench, label: firstLabel });
    this.bench = new Signal(bench);
  }

  // Changes

  /** A step of the history; those with the same `key` that follow each other are one until settle(). */
  change(label: string, key: string | null, change: (bench: Bench) => Bench): void {
    this.history.push(change(this.bench.value), label, key);
    this.bench.set(this.history.value);
  }

  changeDesign(label: string, key: string | null, change: (design: Design) => Design): void {
    this.change(label, key && `${this.bench.value.active} ${key}`, (bench) => withDesign(bench, change));
  }

  settle(): void {
    this.history.settle();
  }

  /** Which design the panels are about: not a step of its own. */
  activate(side: Side): void {
    const bench = this.bench.value;
    if (bench.active === side || (side === 'b' && !bench.b)) return;
    this.history.settle();
    this.bench.set({ ...bench, active: side });
  }

  undo(): void {
    if (this.history.undo()) this.bench.set(this.history.value);
  }

  redo(): void {
    if (this.history.redo()) this.bench.set(this.history.value);
  }

  go(position: number): void {
    if (this.history.go(position)) this.bench.set(this.history.value);
  }

  // What is known

  get side(): Side {
    return this.bench.value.active;
  }

  style(id: string): Style | undefined {
    return this.#styles.get(id);
  }

  /** A design's values: the style's, as the preview found them for its size, and what was changed. */
  values(design: Design, notes?: PreviewNotes): FieldValues {
    return { ...this.style(design.style)?.values, ...notes?.values, ...design.fields };
  }

  /** The fit of a side, if it is of what stands there now. */
  fresh(side: Side): Fitted | null {
    const fitted = this.fitted.value[side];
    const bench = this.bench.value;
    const design = side === 'b' ? bench.b : bench.a;
    if (!fitted || !design || fitted.prescription !== bench.prescription) return null;
    const same = fitted.design.style === design.style && fitted.design.size === design.size && JSON.stringify(fitted.design.fields) === JSON.stringify(design.fields);
    return same ? fitted : null;
  }
}
