// The ring as it sees now, sensor by sensor.
import { get } from '../../core/api';
import { booth } from '../../core/booth';
import { h, replace } from '../../core/dom';
import { connected, on, tell } from '../../core/live';
import { newId, table } from '../../core/ui';
import { colourOf, cssColour, diverging, sequential, shareOf } from '../../charts/colour_map';
import { plot } from '../../charts/plot';
import { angleOfSensor, sensorCount, sensorsPerBoard } from '../../charts/polar';
import { type RingCell, ringView } from '../../charts/ring_view';
import { ground, onTheme } from '../../charts/theme';
import { t } from '../../words/technician';
import { type LevelMessage, LiveRing } from './live_ring';
import { badge, card, Ends, pageOf, percent, quantity, terms } from './page_parts';
import './technician.css';

interface SensorRow {
  index: number;
  /** Serial number of its board. */
  board: number | null;
  angle_deg: number;
  returns_share: number | null;
  mean_mm: number | null;
  noise_mm: number | null;
  drift_mm: number | null;
  alarm: boolean;
}

type Shown = 'missing' | 'scatter' | 'drift';
const scales: Record<Shown, { low: number; high: number; unit: string; times: number; digits: number }> = {
  missing: { low: 0, high: 0.3, unit: '%', times: 100, digits: 0 },
  scatter: { low: 0, high: 2, unit: 'mm', times: 1, digits: 1 },
  drift: { low: -0.5, high: 0.5, unit: 'mm', times: 1, digits: 1 },
};
// What is wrong whatever the page's colours say (docs/technician.md: drift; docs/formats.md: quality of a scan).
const alarmedMissing = 0.5;

export const sensorsPage = {
  mount(root: HTMLElement): () => void {
    const view = new SensorsView();
    view.show(root);
    return () => view.ends.end();
  },
};

/** The page while it is open. */
class SensorsView {
  readonly ends = new Ends();
  readonly #live = new LiveRing();
  readonly #rows: SensorRow[] = [];
  #shown: Shown = 'missing';
  #picked = 45;
  #lastLevelMs = 0;
  #waiting = 0;
  #cellsDrawnMs = 0;
  readonly #ring = ringView({ ringRadius: booth.value.booth?.ring_radius_mm ?? 600, pick: (sensor) => this.#pick(sensor) });
  readonly #number = sensorNumber((sensor) => this.#pick(sensor));
  readonly #history = plot({
    label: t('history_label'),
    xLabel: t('levels_ago'),
    yLabel: t('radius_mm'),
    height: 170,
    legend: false,
    curves: [{ label: t('radius'), colour: '--accent', pointsOnly: true, unit: 'mm' }],
  });
  readonly #line = h('p', { class: 'row', role: 'status' });
  readonly #detail = h('div', null);
  readonly #alarms = h('div', null);
  readonly #all = h('div', null);
  readonly #legend = h('div', { class: 'row small number' });

  show(root: HTMLElement): void {
    const choices = shownChoice((shown) => {
      this.#shown = shown;
      this.#drawColours();
    });
    pageOf(
      root,
      t('sensors_title'),
      this.#line,
      h(
        'div',
        { class: 'sensors-layout' },
        h('div', { class: 'stack' }, choices, this.#legend, this.#ring.root),
        h('div', { class: 'stack' }, card(t('sensor'), this.#number.root, this.#detail, this.#history.root), card(t('alarms'), this.#alarms)),
      ),
      h('details', { class: 'card' }, h('summary', null, t('all_sensors')), this.#all),
    );
    this.#follow();
    this.#drawLine();
    this.#drawColours();
    this.#pick(this.#picked);
    void this.#load();
  }

  #follow(): void {
    const { ends } = this;
    ends.add(this.#history.dispose);
    ends.add(on('level', (message) => this.#take(message as unknown as LevelMessage)));
    ends.add(() => cancelAnimationFrame(this.#waiting));
    ends.add(connected.watch((yes) => yes && tell({ type: 'subscribe', sensor_step: 1 })));
    ends.add(on('scan_result', () => void this.#load()));
    const clock = setInterval(() => this.#drawLine(), 1000);
    ends.add(() => clearInterval(clock));
    ends.add(onTheme(() => this.#drawColours()));
  }

  async #load(): Promise<void> {
    try {
      const answer = await get<{ sensors: SensorRow[] }>('/api/technician/sensors');
      for (const row of answer.sensors) this.#rows[row.index] = row;
      this.#drawCells();
      this.#drawDetail();
      replace(this.#all, allSensors(this.#rows, (sensor) => this.#pick(sensor)));
    } catch {
      replace(this.#all, h('p', { class: 'muted' }, t('no_history_yet')));
    }
  }

  #take(level: LevelMessage): void {
    this.#live.take(level, Date.now());
    this.#lastLevelMs = Date.now();
    if (this.#waiting === 0) this.#waiting = requestAnimationFrame(() => this.#drawLive());
  }

  /** The outline with every frame, the numbers three times a second: they are read, not watched. */
  #drawLive(): void {
    this.#waiting = 0;
    this.#ring.setRadii(this.#live.radius);
    const now = performance.now();
    if (now - this.#cellsDrawnMs < 300) return;
    this.#cellsDrawnMs = now;
    this.#drawCells();
    this.#drawDetail();
    this.#drawLine();
  }

  #pick(sensor: number): void {
    this.#picked = sensor;
    this.#ring.setPicked(sensor);
    if (this.#number.input.value !== String(sensor)) this.#number.input.value = String(sensor);
    this.#drawDetail();
  }

  #valueOf(sensor: number): number {
    const row = this.#rows[sensor];
    const live = this.#live.levels > 0;
    if (this.#shown === 'drift') return row?.drift_mm ?? NaN;
    if (this.#shown === 'scatter') return live ? this.#live.scatter(sensor) : (row?.noise_mm ?? NaN);
    if (live) return this.#live.noReturnShare(sensor);
    return typeof row?.returns_share === 'number' ? 1 - row.returns_share : NaN;
  }

  #alarmOf(sensor: number): string | null {
    const row = this.#rows[sensor];
    if (row?.alarm) return driftAlarm(row);
    const missing = this.#live.levels > 0 ? this.#live.noReturnShare(sensor) : 0;
    return missing > alarmedMissing ? t('sees_little', { share: percent(missing) }) : null;
  }

  #drawColours(): void {
    replace(this.#legend, ...legendOf(this.#shown));
    this.#drawCells();
  }

  #drawCells(): void {
    this.#ring.setCells(Array.from({ length: sensorCount }, (_, sensor) => cellOf(this.#valueOf(sensor), this.#shown, this.#alarmOf(sensor) !== null)));
    drawAlarms(this.#alarms, (sensor) => this.#alarmOf(sensor), (sensor) => this.#pick(sensor));
  }

  #drawDetail(): void {
    replace(this.#detail, detailOf(this.#picked, this.#live, this.#rows[this.#picked], this.#alarmOf(this.#picked)));
    const past = this.#live.historyOf(this.#picked);
    this.#history.set([past.map((_, k) => k + 1 - past.length), [...past]]);
  }

  #drawLine(): void {
    drawLine(this.#line, this.#live, this.#lastLevelMs);
  }
}

function drawLine(line: HTMLElement, live: LiveRing, lastLevelMs: number): void {
  const quiet = Date.now() - lastLevelMs > 1500;
  if (live.levels === 0 || quiet) {
    const text = live.levels === 0 ? t('no_levels_yet') : t('no_levels_now', { n: Math.round((Date.now() - lastLevelMs) / 1000) });
    return replace(line, badge(t('at_rest')), text);
  }
  replace(line, badge(t('running'), 'good'), h('span', { class: 'number' }, t('live_line', { levels: live.levels, z: live.zMm.toFixed(1), delay: Math.max(0, live.delayMs).toFixed(0) })));
}

function cellOf(value: number, shown: Shown, marked: boolean): RingCell {
  if (!Number.isFinite(value)) return { colour: null, marked };
  const { low, high } = scales[shown];
  const colours = shown === 'drift' ? diverging[ground()] : sequential;
  return { colour: cssColour(colourOf(colours, shareOf(value, low, high))), marked };
}

function legendOf(shown: Shown): Node[] {
  const { low, high, unit, times, digits } = scales[shown];
  const colours = shown === 'drift' ? diverging[ground()] : sequential;
  const bar = h('canvas', { width: colours.length, height: 1, class: 'heat-legend', 'aria-hidden': 'true' });
  const context = bar.getContext('2d')!;
  colours.forEach((colour, k) => {
    context.fillStyle = cssColour(colour);
    context.fillRect(k, 0, 1, 1);
  });
  const text = (value: number) => `${shown === 'drift' && value > 0 ? '+' : ''}${(times * value).toFixed(digits)} ${unit}`;
  return [h('span', null, text(low)), bar, h('span', null, `${text(high)} ${t('and_more')}`), h('span', null, `▲ ${t('alarm_mark')}`), h('span', null, `┆ ${t('no_return')}`)];
}

function drawAlarms(root: HTMLElement, alarmOf: (sensor: number) => string | null, pick: (sensor: number) => void): void {
  const told = Array.from({ length: sensorCount }, (_, sensor) => ({ sensor, text: alarmOf(sensor) })).filter((one) => one.text !== null);
  const key = told.map((one) => `${one.sensor}${one.text}`).join();
  if (root.dataset['shown'] === key && root.childNodes.length > 0) return;
  root.dataset['shown'] = key;
  if (told.length === 0) return replace(root, h('p', { class: 'note good' }, t('no_alarms')));
  const entry = (one: { sensor: number; text: string | null }) =>
    h('li', null, h('button', { type: 'button', class: 'button', onclick: () => pick(one.sensor) }, `▲ ${t('sensor_n', { n: one.sensor })}`), ' ', one.text);
  const few = 12;
  replace(root, h('ul', { class: 'alarm-list' }, told.slice(0, few).map(entry)), told.length > few ? h('p', null, t('and_n_more', { n: told.length - few })) : null);
}

function detailOf(sensor: number, live: LiveRing, row: SensorRow | undefined, alarm: string | null): HTMLElement {
  const radius = live.radius[sensor];
  const ringRadius = booth.value.booth?.ring_radius_mm ?? 600;
  const now = radius === undefined ? '–' : radius === null ? t('no_return') : `${quantity(ringRadius - radius, 1, 'mm')} (${t('radius')} ${quantity(radius, 1, 'mm')})`;
  const board = Math.floor(sensor / sensorsPerBoard);
  return terms([
      [t('place'), t('place_text', { board: board + 1, serial: row?.board ? ` (${row.board})` : '', channel: sensor % sensorsPerBoard, angle: angleOfSensor(sensor) })],
      [t('range_now'), now],
      [t('no_return_live'), percent(live.noReturnShare(sensor))],
      [t('scatter_live'), quantity(live.scatter(sensor), 2, 'mm')],
      [t('last_scan'), row ? t('last_scan_text', { returns: percent(row.returns_share, 1), noise: quantity(row.noise_mm, 2, 'mm') }) : '–'],
      [t('drift'), row && typeof row.drift_mm === 'number' ? `${row.drift_mm > 0 ? '+' : ''}${quantity(row.drift_mm, 3, 'mm')}` : '–'],
      [t('alarm'), alarm ? h('strong', { class: 'bad-text' }, `▲ ${alarm}`) : t('none')],
  ]);
}

function driftAlarm(row: SensorRow): string {
  return t('drifted', { mm: quantity(row.drift_mm, 2, 'mm') });
}

function sensorNumber(pick: (sensor: number) => void) {
  const id = newId('sensor');
  const input = h('input', { id, type: 'number', min: 0, max: sensorCount - 1, step: 1, value: '45', class: 'number' });
  input.addEventListener('input', () => {
    const sensor = input.valueAsNumber;
    if (Number.isInteger(sensor) && sensor >= 0 && sensor < sensorCount) pick(sensor);
  });
  return { root: h('div', { class: 'field narrow' }, h('label', { for: id }, t('sensor_number')), input), input };
}

function shownChoice(choose: (shown: Shown) => void): HTMLElement {
  const texts: [Shown, string][] = [
    ['missing', t('show_missing')],
    ['scatter', t('show_scatter')],
    ['drift', t('show_drift')],
  ];
  const buttons = texts.map(([shown, text], k) =>
    h('button', { type: 'button', class: 'button', 'aria-pressed': String(k === 0), onclick: () => {
      buttons.forEach((one, other) => one.setAttribute('aria-pressed', String(other === k)));
      choose(shown);
    } }, text),
  );
  return h('div', { class: 'row', role: 'group', 'aria-label': t('rim_shows') }, ...buttons);
}

function allSensors(rows: readonly SensorRow[], pick: (sensor: number) => void): HTMLElement {
  const show = (row: SensorRow) => h('button', { type: 'button', class: 'button', onclick: () => pick(row.index), 'aria-label': t('sensor_n', { n: row.index }) }, String(row.index));
  return table(
    t('all_sensors'),
    [
      { head: t('sensor'), cell: show },
      { head: t('board_head'), cell: (row) => row.board ?? '–', number: true },
      { head: t('angle_head'), cell: (row) => row.angle_deg, number: true },
      { head: t('returns_head'), cell: (row) => percent(row.returns_share, 1), number: true },
      { head: t('mean_head'), cell: (row) => quantity(row.mean_mm, 1, 'mm'), number: true },
      { head: t('noise_head'), cell: (row) => quantity(row.noise_mm, 2, 'mm'), number: true },
      { head: t('drift'), cell: (row) => quantity(row.drift_mm, 3, 'mm'), number: true },
      { head: t('alarm'), cell: (row) => (row.alarm ? `▲ ${driftAlarm(row)}` : '') },
    ],
    rows.filter(Boolean),
  ).root;
}
