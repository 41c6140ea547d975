// Pieces that the technician's and the developer's pages share.
import { h, replace } from '../../core/dom';
import { failurePanel } from '../../core/ui';
import { language } from '../../core/words';
import { tShell } from '../../words/shell';

/** Things to be ended when a page is left. */
export class Ends {
  #all: (() => void)[] = [];

  add(end: () => void): void {
    this.#all.push(end);
  }

  end(): void {
    for (const end of this.#all.splice(0).reverse()) end();
  }
}

/** Loads and draws into `root`; while it loads it says so, a failure stands there with a button to try again. */
export function loadInto<T>(root: HTMLElement, load: () => Promise<T>, draw: (loaded: T) => void): Promise<void> {
  replace(root, h('p', { class: 'muted', role: 'status' }, tShell('loading')));
  return load().then(
    (loaded) => {
      replace(root);
      draw(loaded);
    },
    (error: unknown) => replace(root, failurePanel(error, () => void loadInto(root, load, draw))),
  );
}

/** Puts a page's heading and parts into its root. */
export function pageOf(root: HTMLElement, title: string, ...content: (Node | null)[]): void {
  root.classList.add('stack');
  replace(root, h('h1', null, title), ...content);
}

/** A number with its unit, or a dash. */
export function quantity(value: number | null | undefined, digits: number, unit: string): string {
  return typeof value === 'number' && Number.isFinite(value) ? `${value.toFixed(digits).replace('-', '−')} ${unit}` : '–';
}

export function percent(share: number | null | undefined, digits = 0): string {
  return typeof share === 'number' && Number.isFinite(share) ? `${(100 * share).toFixed(digits)} %` : '–';
}

export function bytesText(bytes: number): string {
  return bytes < 1e6 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

/** Date and time as the language writes them, in the time zone of the screen. */
export function timeText(timeMs: number | null | undefined): string {
  if (!timeMs) return '–';
  return new Intl.DateTimeFormat(language.value === 'ja' ? 'ja-JP' : 'en-GB', { dateStyle: 'medium', timeStyle: 'short' }).format(timeMs);
}

/** Terms and what they are. */
export function terms(rows: readonly (readonly [term: string, what: string | Node])[]): HTMLElement {
  return h('dl', { class: 'terms' }, rows.flatMap(([term, what]) => [h('dt', null, term), h('dd', null, what)]));
}

/** A word on coloured ground. */
export function badge(text: string, kind: '' | 'good' | 'warn' | 'bad' = ''): HTMLElement {
  return h('span', { class: `badge ${kind}` }, text);
}

/** A card with a heading. */
export function card(title: string, ...content: (Node | string | null)[]): HTMLElement {
  return h('section', { class: 'card stack' }, h('h2', null, title), ...content);
}
