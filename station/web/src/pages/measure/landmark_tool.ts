// Landmarks as they were found, moved by hand, and what that does to the table of measurements.
import { h, replace } from '../../core/dom';
import { button } from '../../core/ui';
import { tMeasure, landmarkWord } from '../../words/measure';
import { curvesOf, numberOf, type Landmark, type Measurement } from './api';
import { changeText, intervalText, valueText } from './numbers';
import { onSurfaceTap, SurfaceCursor } from './surface_cursor';
import { lineColours, Results, type Bench, type Tool } from './tool';

export function landmarkTool(bench: Bench): Tool {
  const work = new LandmarkWork(bench);
  return { root: work.root, begin: () => void work.begin(), end: () => work.end() };
}

class LandmarkWork {
  readonly root: HTMLElement;
  readonly #list = h('ul', { class: 'landmarks' });
  readonly #table = h('div', { class: 'stack', 'aria-live': 'polite' });
  readonly #state = new Results();
  #landmarks: Landmark[] = [];
  #measurements: Measurement[] = [];
  /** The table before the last change: what differs from it is marked. */
  #before: Map<string, number> = new Map();
  #cursors = new Map<string, SurfaceCursor>();
  /** The one that is placed by the next tap. */
  #chosen: string | null = null;
  #unwatch = (): void => {};
  #open = false;

  constructor(private readonly bench: Bench) {
    const reset = button(tMeasure('reset'), async () => {
      await this.#apply(() => this.bench.api.resetLandmarks());
    });
    this.root = h('div', { class: 'stack' }, this.#state.root, this.#list, reset, this.#table);
  }

  async begin(): Promise<void> {
    this.#open = true;
    this.#unwatch = onSurfaceTap(this.bench.viewer, (x, y) => {
      const hit = this.bench.viewer.pick('body', x, y);
      if (!hit || !this.#chosen) return;
      const id = this.#chosen;
      void this.#confirmed(id, x, y);
    });
    this.#state.hint(tMeasure('landmark_hint'));
    try {
      [this.#landmarks, this.#measurements] = await Promise.all([this.bench.api.landmarks(), this.bench.api.measurements()]);
      if (this.#open) this.#show();
    } catch (error) {
      this.#state.fail(error);
    }
  }

  end(): void {
    this.#open = false;
    this.#unwatch();
    for (const cursor of this.#cursors.values()) cursor.remove();
    this.#cursors.clear();
    this.bench.viewer.clear('landmark.');
  }

  async #confirmed(id: string, x: number, y: number): Promise<void> {
    try {
      const point = await this.bench.api.pick(this.bench.viewer.rayAt(x, y));
      const level = this.#landmarks.find((one) => one.id === id)?.kind === 'level';
      if (point) await this.#move(id, level ? { z_mm: point.z_mm } : { theta_deg: point.theta_deg, z_mm: point.z_mm });
    } catch (error) {
      this.#state.fail(error);
    }
  }

  #move(id: string, place: { theta_deg?: number; z_mm: number }): Promise<void> {
    return this.#apply(() => this.bench.api.setLandmark(id, place));
  }

  /** Changes landmarks and computes the table again. */
  async #apply(change: () => Promise<Landmark[]>): Promise<void> {
    this.#state.hint(tMeasure('recomputing'));
    try {
      this.#before = valuesOf(this.#measurements);
      this.#landmarks = await change();
      this.#measurements = await this.bench.api.measurements();
      if (this.#open) this.#show();
      this.#state.hint(tMeasure('landmark_hint'));
    } catch (error) {
      this.#state.fail(error);
    }
  }

  #show(): void {
    replace(this.#list, ...this.#landmarks.map((landmark) => this.#row(landmark)));
    for (const landmark of this.#landmarks) this.#mark(landmark);
    this.#showTable();
  }

  #row(landmark: Landmark): HTMLElement {
    const { id, source, sigma_mm, found } = landmark;
    const sigma = found && sigma_mm !== null ? ` ± ${(1.96 * sigma_mm).toFixed(1)} mm` : '';
    return h('li', null, h('button', {
      type: 'button',
      class: 'landmark',
      'aria-pressed': String(this.#chosen === id),
      onclick: () => this.#choose(id),
    }, h('span', null, landmarkWord(id, landmark.name)), h('span', { class: `badge ${source === 'given' ? 'warn' : ''}` }, found ? `${tMeasure(sourceWord(source))}${sigma}` : tMeasure('not_found'))));
  }

  #choose(id: string): void {
    this.#chosen = this.#chosen === id ? null : id;
    replace(this.#list, ...this.#landmarks.map((landmark) => this.#row(landmark)));
    const landmark = this.#landmarks.find((one) => one.id === id);
    this.#state.hint(this.#chosen ? tMeasure('landmark_chosen', { name: landmarkWord(id, landmark?.name ?? id) }) : tMeasure('landmark_hint'));
    if (this.#chosen) this.#cursors.get(id)?.focus();
    if (landmark?.theta_deg !== null && landmark?.theta_deg !== undefined) this.bench.viewer.glideTo({ ...this.bench.viewer.camera(), azimuth_deg: landmark.theta_deg });
  }

  /** A handle on a point's place, a line at a level's height. */
  #mark(landmark: Landmark): void {
    const { id, kind, x_mm, y_mm, z_mm, theta_deg, found } = landmark;
    const { viewer, api, low_mm, high_mm } = this.bench;
    if (!found || z_mm === null) return;
    if (kind === 'level' || theta_deg === null || x_mm === null || y_mm === null) {
      // The crown lies above the highest level that was scanned.
      if (z_mm <= low_mm || z_mm >= high_mm) return;
      void api.section({ z_mm }).then((section) => {
        if (!this.#open) return;
        section.loops.forEach((loop, i) => viewer.setLine(`landmark.${id}${i}`, loop, { colour: lineColours.quiet, width_px: 2, through: true }));
      }, (error: unknown) => this.#state.fail(error));
      return;
    }
    const old = this.#cursors.get(id);
    const cursor = old ?? new SurfaceCursor(viewer, api, `landmark.${id}`, { letter: '•', label: tMeasure('landmark_handle', { name: landmarkWord(id, landmark.name) }) });
    const length = Math.hypot(x_mm, y_mm) || 1;
    cursor.set({ theta_deg, z_mm, position: [x_mm, y_mm, z_mm], normal: [x_mm / length, y_mm / length, 0], sigma_mm: landmark.sigma_mm, knowledge: 'measured' });
    cursor.moved = (point, how) => {
      if (how === 'settled') void this.#move(id, { theta_deg: point.theta_deg, z_mm: point.z_mm });
    };
    cursor.failed = (error) => this.#state.fail(error);
    this.#cursors.set(id, cursor);
  }

  #showTable(): void {
    const rows = this.#measurements.map((line) => {
      const value = numberOf(line, 'value');
      const before = this.#before.get(line.id);
      // Differences below what is shown are none.
      const changed = value !== null && before !== undefined && Math.abs(value.value - before) >= 0.05;
      return h('tr', { class: changed ? 'changed' : '', onclick: () => this.#showCurve(line) },
        h('th', { scope: 'row' }, h('button', { type: 'button', class: 'link', onclick: () => this.#showCurve(line) }, line.term)),
        h('td', { class: 'number' }, value ? intervalText(value.value, numberOf(line, 'sigma')?.value, value.unit) : '–',
          changed ? h('span', { class: 'badge warn' }, `${changeText(value.value - before, value.unit)} (${valueText(before, value.unit)})`) : null));
    });
    replace(this.#table, h('div', { class: 'table-frame', tabindex: 0, role: 'region', 'aria-label': tMeasure('table') },
      h('table', null, h('caption', null, tMeasure('table')), h('tbody', null, ...rows))));
  }

  #showCurve(line: Measurement): void {
    const { viewer } = this.bench;
    viewer.clear('landmark.curve');
    curvesOf(line).forEach((curve, i) => viewer.setLine(`landmark.curve${i}`, curve, { colour: lineColours.second, width_px: 4, through: true }));
  }
}

function valuesOf(lines: readonly Measurement[]): Map<string, number> {
  return new Map(lines.flatMap((line) => {
    const value = numberOf(line, 'value');
    return value ? [[line.id, value.value] as const] : [];
  }));
}

function sourceWord(source: string | null): 'detected' | 'proportion' | 'given' {
  return source === 'given' || source === 'proportion' ? source : 'detected';
}
