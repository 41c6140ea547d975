// The raw bytes of a level: every frame that passed the buses, with its meaning.
import { get } from '../../core/api';
import { h, replace } from '../../core/dom';
import { check, failurePanel } from '../../core/ui';
import { bytesOfHex, hexLines } from '../../charts/hex_view';
import { t } from '../../words/developer';
import { type Frame, type OpenReplay, type ReplayLevel, secondsOf } from './replay_file';

/** Asks for a level when it has been shown for a moment; the newest one wins. */
export class BytesPanel {
  readonly root = h('div', { class: 'stack' });
  readonly #head = h('p', { class: 'number' });
  readonly #list = h('div', { class: 'frame-list', role: 'listbox', 'aria-label': t('frames'), tabindex: 0 });
  readonly #hex = h('div', { class: 'stack', 'aria-live': 'polite' });
  readonly #empty = check(t('hide_empty'), true, () => this.#draw());
  #timer: ReturnType<typeof setTimeout> | null = null;
  #wanted = -1;
  #level: ReplayLevel | null = null;
  #chosen = 0;

  constructor(private readonly replay: OpenReplay) {
    replace(this.root, h('div', { class: 'row spread' }, this.#head, this.#empty.root), h('div', { class: 'bytes-layout' }, this.#list, this.#hex));
    this.#list.addEventListener('keydown', (event) => {
      const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      this.#choose(Math.min(this.#shown().length - 1, Math.max(0, this.#chosen + step)), true);
    });
  }

  show(level: number): void {
    if (level === this.#wanted) return;
    this.#wanted = level;
    if (this.#timer !== null) clearTimeout(this.#timer);
    this.#timer = setTimeout(() => void this.#load(level), 120);
  }

  dispose(): void {
    if (this.#timer !== null) clearTimeout(this.#timer);
    this.#wanted = -1;
  }

  async #load(level: number): Promise<void> {
    try {
      const told = await get<ReplayLevel>(`/api/replay/${this.replay.replay_id}/level/${level}`);
      if (this.#wanted !== level) return;
      this.#level = told;
      this.#draw();
    } catch (error) {
      if (this.#wanted === level) replace(this.#list, failurePanel(error, () => void this.#load(level)));
    }
  }

  #shown(): Frame[] {
    const frames = this.#level?.frames ?? [];
    return this.#empty.input.checked ? frames.filter((frame) => frame.bytes_hex !== '') : frames;
  }

  #draw(): void {
    const level = this.#level;
    if (!level) return;
    const frames = this.#shown();
    this.#head.textContent = t('level_head', { n: level.n, sweep: level.sweep, level: level.level, z: level.z_mm.toFixed(3), time: secondsOf(this.replay, level.time_ns).toFixed(6), frames: level.frames.length });
    replace(this.#list, ...frames.map((frame, k) => this.#row(frame, k)));
    if (frames.length === 0) {
      replace(this.#list, h('div', { class: 'note', role: 'option', 'aria-selected': 'false' }, t('no_bytes')));
      replace(this.#hex);
      return;
    }
    this.#choose(Math.min(this.#chosen, frames.length - 1), false);
  }

  #row(frame: Frame, k: number): HTMLElement {
    return h(
      'div',
      { class: 'frame', role: 'option', 'aria-selected': 'false', id: `frame-${k}`, onclick: () => this.#choose(k, false) },
      h('span', { class: 'number' }, secondsOf(this.replay, frame.time_ns).toFixed(6)),
      h('span', null, `${frame.bus} ${arrow(frame.direction)}`),
      h('span', { class: 'number' }, `${frame.bytes_hex.replace(/\s/g, '').length / 2} B`),
      h('span', { class: 'meaning' }, frame.meaning),
    );
  }

  #choose(k: number, scroll: boolean): void {
    this.#chosen = k;
    const rows = [...this.#list.children];
    rows.forEach((row, other) => row.setAttribute('aria-selected', String(other === k)));
    this.#list.setAttribute('aria-activedescendant', `frame-${k}`);
    if (scroll) rows[k]?.scrollIntoView({ block: 'nearest' });
    const frame = this.#shown()[k];
    if (frame) replace(this.#hex, ...hexOf(frame));
  }
}

function arrow(direction: string): string {
  if (/^(in|rx|received|read)/i.test(direction)) return '←';
  if (/^(out|tx|sent|write)/i.test(direction)) return '→';
  return direction;
}

function hexOf(frame: Frame): HTMLElement[] {
  const bytes = bytesOfHex(frame.bytes_hex);
  if (!bytes) return [h('p', { class: 'note bad' }, t('bad_hex'))];
  const lines = hexLines(bytes);
  const text = lines.map((line) => `${line.offset}  ${line.hex}  ${line.text}`).join('\n');
  return [h('p', { class: 'meaning' }, h('strong', null, t('meaning')), ' ', frame.meaning), h('pre', { class: 'hex', tabindex: 0, role: 'region', 'aria-label': t('bytes_n', { n: bytes.length }) }, text || t('no_bytes'))];
}
