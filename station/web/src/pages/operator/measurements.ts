// Step 7: the measures, with their intervals, in a table and on the body.
import { get, post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { quantity, type Units } from '../../core/format';
import type { Page } from '../../core/page';
import { session } from '../../core/session';
import { button, choice, failurePanel, field, linkButton, table, type Column } from '../../core/ui';
import { language } from '../../core/words';
import { tOperator as t } from '../../words/operator';
import type { BodyPicture } from './body_picture';
import { readMeasurements, type Line, type MeasurementsAnswer } from './measurement_lines';
import type { Scan } from './records';
import { stepFrame, type StepFrame } from './step_frame';
import { takeUp } from './visit';

export const measurementsPage: Page = {
  path: '/scans/:scan/measurements',
  roles: ['operator'],
  title: null,
  mount(root, parameters) {
    const scanId = parameters['scan'] ?? '';
    const shown = new Measures(scanId);
    const open = async () => {
      try {
        const [scan, answer] = await Promise.all([
          get<Scan>(`/api/scans/${encodeURIComponent(scanId)}`),
          get<MeasurementsAnswer>(`/api/scans/${encodeURIComponent(scanId)}/measurements?language=${language.value}`),
        ]);
        await takeUp(scan);
        shown.show(root, scan, readMeasurements(answer), answer);
      } catch (error) {
        shown.fail(root, error, () => void open());
      }
    };
    void open();
    return () => shown.dispose();
  },
};

class Measures {
  readonly #scanId: string;
  #gone = false;
  #frame: StepFrame | null = null;
  #picture: BodyPicture | null = null;
  #units: Units = session.value?.units ?? 'mm';
  #lines: Line[] = [];
  #chosen = new Set<string>();

  constructor(scanId: string) {
    this.#scanId = scanId;
  }

  dispose(): void {
    this.#gone = true;
    this.#frame?.end();
    this.#picture?.dispose();
    this.#picture = null;
  }

  fail(root: HTMLElement, error: unknown, again: () => void): void {
    if (!this.#gone) replace(root, failurePanel(error, again));
  }

  show(root: HTMLElement, scan: Scan, lines: Line[], answer: MeasurementsAnswer): void {
    if (this.#gone) return;
    this.#lines = lines;
    this.#chosen = new Set(lines.filter((line) => line.main).map((line) => line.id));
    const frame = stepFrame(root, { step: 'step_measures', title: t('measures_title'), back: `/scans/${this.#scanId}` });
    this.#frame = frame;
    const picture = h('div', { class: 'body-side stack' });
    const list = h('div', null);
    const search = field(t('measures_search'), 'search', { type: 'search' });
    const units = choice(t('units'), 'units', [['mm', 'mm'], ['cm', 'cm'], ['inch', t('inch')]], this.#units);
    const redraw = () => this.#drawTable(list, search.value);
    search.input.addEventListener('input', redraw);
    units.input.addEventListener('change', () => {
      this.#units = units.input.value as Units;
      redraw();
      this.#drawLines();
    });
    redraw();
    replace(
      frame.content,
      h('div', { class: 'measures' }, picture, h('div', { class: 'stack' }, h('div', { class: 'columns' }, search.root, units.root), list, h('p', { class: 'muted small' }, t('measures_explain')), omitted(answer))),
    );
    replace(
      frame.actions,
      linkButton(t('measures_by_hand'), `/scans/${this.#scanId}/measure`),
      linkButton(t('measures_glasses'), `/scans/${this.#scanId}/glasses`, { large: true }),
      linkButton(t('measures_on'), `/scans/${this.#scanId}/handover`, { kind: 'primary', large: true }),
    );
    if (scan.summary?.released) void this.#openPicture(picture);
    else this.#askRelease(picture);
  }

  /** The body stays hidden until the person says that it may be seen. */
  #askRelease(root: HTMLElement): void {
    const release = button(
      t('release_button'),
      async () => {
        await post(`/api/scans/${encodeURIComponent(this.#scanId)}/release`);
        await this.#openPicture(root);
      },
      { large: true },
    );
    replace(root, h('div', { class: 'card stack hidden-body' }, h('h2', null, t('release_title')), h('p', null, t('release_text')), h('div', null, release)));
  }

  async #openPicture(root: HTMLElement): Promise<void> {
    try {
      const { BodyPicture: Picture } = await import('./body_picture');
      if (this.#gone) return;
      replace(root);
      this.#picture = new Picture(root);
      await this.#picture.load(this.#scanId);
      this.#drawLines();
    } catch (error) {
      if (this.#gone) return;
      this.#picture?.dispose();
      this.#picture = null;
      replace(root, failurePanel(error, () => void this.#openPicture(root)));
    }
  }

  #drawTable(root: HTMLElement, search: string): void {
    const wanted = search.toLowerCase();
    const rows = this.#lines.filter((line) => line.term.toLowerCase().includes(wanted) || line.id.includes(wanted));
    const text = (line: Line) => quantity(line.value, line.half, line.unit, this.#units);
    const columns: Column<Line>[] = [
      { head: t('measures_what'), cell: (line) => this.#nameCell(line) },
      { head: t('measures_value'), number: true, cell: (line) => `${text(line).value} ${text(line).unit}` },
      { head: '± 95 %', number: true, cell: (line) => text(line).half },
      { head: t('measures_seen'), number: true, cell: (line) => (line.seen === null ? '' : `${Math.round(100 * line.seen)} %`) },
    ];
    replace(root, table(t('measures_title'), columns, rows).root);
  }

  #nameCell(line: Line): HTMLElement {
    const note = line.note ? h('span', { class: 'muted small block' }, line.note) : null;
    if (!line.curve) return h('span', { title: line.definition }, line.term, note);
    const box = h('input', {
      type: 'checkbox',
      checked: this.#chosen.has(line.id),
      onchange: () => {
        if (box.checked) this.#chosen.add(line.id);
        else this.#chosen.delete(line.id);
        this.#drawLines();
      },
    });
    return h('span', null, h('label', { class: 'check', title: line.definition }, box, h('span', null, line.term)), note);
  }

  #drawLines(): void {
    const chosen = this.#lines.filter((line) => this.#chosen.has(line.id));
    this.#picture?.draw(
      chosen.map((line) => {
        const text = quantity(line.value, line.half, line.unit, this.#units);
        return { id: line.id, curve: line.curve ?? [], label: `${line.term} ${text.value} ${text.unit}` };
      }),
    );
  }
}

function omitted(answer: MeasurementsAnswer): HTMLElement | null {
  const list = answer.omitted ?? [];
  if (list.length === 0) return null;
  const line = (one: unknown) => h('li', null, typeof one === 'string' ? one : Object.values(one as object).join(': '));
  return h('details', null, h('summary', null, t('measures_omitted', { n: list.length })), h('ul', null, ...list.map(line)));
}
