// What every tool of measuring by hand has: its controls, and marks on the body while it is open.
import { h, replace } from '../../core/dom';
import { failurePanel } from '../../core/ui';
import type { Viewer } from '../../view3d/viewer';
import type { MeasureApi } from './api';

/** What tools work on. */
export interface Bench {
  viewer: Viewer;
  api: MeasureApi;
  /** Lowest and highest height of the model, mm. */
  low_mm: number;
  high_mm: number;
}

export interface Tool {
  root: HTMLElement;
  /** The tool is opened: it shows its marks and listens. */
  begin(): void;
  /** Another one is opened, or the page is left: marks go, listeners go. */
  end(): void;
}

export interface Row {
  term: string;
  value: string;
  /** Share of it that was measured, 0 … 1. */
  note?: string;
}

/** Where a tool says what it found; read out as it changes. */
export class Results {
  readonly root = h('div', { class: 'results', 'aria-live': 'polite' });

  show(rows: readonly Row[], note = ''): void {
    replace(this.root,
      h('dl', { class: 'result-list' }, ...rows.flatMap((row) => [h('dt', null, row.term), h('dd', null, h('strong', { class: 'number' }, row.value), row.note ? h('span', { class: 'muted small' }, ` ${row.note}`) : null)])),
      note ? h('p', { class: 'muted small' }, note) : null);
  }

  hint(text: string): void {
    replace(this.root, h('p', { class: 'muted' }, text));
  }

  fail(error: unknown): void {
    replace(this.root, failurePanel(error));
  }
}

/** Colours of lines on the body: readable on it in both themes. */
export const lineColours = { main: '#0b4fc4', second: '#b3261e', quiet: '#5a4a00' } as const;
