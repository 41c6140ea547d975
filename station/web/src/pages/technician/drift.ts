// How the sensors have drifted since the calibration, from customer to customer.
import { get, post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { button, ownWords } from '../../core/ui';
import { heatView, indexSide } from '../../charts/heat_view';
import { plot } from '../../charts/plot';
import { angleOfSensor, sensorCount, sensorsPerBoard } from '../../charts/polar';
import { robustRange } from '../../charts/scale';
import { t } from '../../words/technician';
import { driftMatrix, type DriftSensor } from './drift_matrix';
import { jobPanel } from './job_panel';
import type { Job } from '../../core/contract';
import { jsonView } from './json_view';
import { card, Ends, loadInto, pageOf, quantity, timeText } from './page_parts';
import './technician.css';

interface Drift {
  sensors: DriftSensor[];
  alarms: { text: string; advice: string; sensor?: number }[];
  scans: number;
  baseline_ready: boolean;
  reference_check: { time_ms: number; passed: boolean; common_mm: number; findings: string[]; advice: string[] } | null;
  update: Pick<Job, 'state' | 'error'> | null;
}

export const driftPage = {
  mount(root: HTMLElement): () => void {
    const ends = new Ends();
    const shown = new Ends();
    ends.add(() => shown.end());
    const panel = jobPanel(t('drift_updating'));
    ends.add(panel.dispose);
    const body = h('div', { class: 'stack' });
    const load = () => {
      shown.end();
      return loadInto(body, () => get<Drift>('/api/technician/drift'), (drift) => replace(body, ...drawn(drift, shown)));
    };
    const update = button(t('drift_update'), () => panel.run(() => post<Job<object>>('/api/technician/drift/update')).then(load, () => {}));
    pageOf(root, t('drift_title'), h('p', null, t('drift_explain')), h('p', { class: 'row' }, update), panel.root, body);
    void load();
    return () => ends.end();
  },
};

function drawn(drift: Drift, ends: Ends): Node[] {
  return [...failedUpdate(drift.update), ...judged(drift, ends)];
}

/** It runs by itself after every scan: nobody was looking. */
function failedUpdate(update: Drift['update']): Node[] {
  if (update?.state !== 'failed') return [];
  return [h('p', { class: 'note bad', role: 'alert' }, h('strong', null, `▲ ${t('drift_update_failed')}`), ownWords([update.error?.seen, update.error?.advice].filter(Boolean).join(': '), ''))];
}

function judged(drift: Drift, ends: Ends): Node[] {
  const alarms = drift.alarms.map((one) => h('p', { class: 'note bad' }, h('strong', null, `▲ ${one.text}`), one.advice ? h('br') : null, one.advice));
  const early = drift.baseline_ready ? [] : [h('p', { class: 'note' }, t('baseline_not_ready', { n: drift.scans }))];
  const alarmCard = card(t('alarms'), ...early, ...(alarms.length > 0 ? alarms : [h('p', { class: 'note good' }, `✓ ${t('no_drift')}`)]));
  const { times, matrix } = driftMatrix(drift.sensors);
  if (times.length === 0) return [alarmCard, h('p', { class: 'note' }, t('no_history_yet')), checkCard(drift.reference_check)];
  return [alarmCard, ...trends(drift, times, matrix, ends), checkCard(drift.reference_check)];
}

function trends(drift: Drift, times: number[], matrix: ReturnType<typeof driftMatrix>['matrix'], ends: Ends): Node[] {
  const range = robustRange(matrix.values, 0.995, { symmetric: true, least: 0.4 });
  const title = h('h2', null);
  const one = plot({
    label: t('drift_one_label'),
    xLabel: t('time_utc'),
    yLabel: t('offset_mm'),
    xTime: true,
    yAtLeast: [-0.3, 0.3],
    height: 260,
    band: [1, 2],
    curves: [
      { label: t('plus_2_sigma'), colour: '--edge', dashed: true, unit: 'mm', digits: 3 },
      { label: t('minus_2_sigma'), colour: '--edge', dashed: true, unit: 'mm', digits: 3 },
      { label: t('offset'), colour: '--accent', unit: 'mm', digits: 3 },
    ],
  });
  const pick = (row: number, sensor: number) => {
    map.setCursor(row, sensor);
    title.textContent = t('drift_of', { n: sensor, board: Math.floor(sensor / sensorsPerBoard) + 1, angle: angleOfSensor(sensor), value: valueText(matrix.values[row * sensorCount + sensor], times[row]) });
    const points = drift.sensors.find((each) => each.index === sensor)?.points ?? [];
    const bound = (sign: number) => points.map(([, offset, sigma]) => (offset === null || sigma === null ? null : offset + sign * 2 * sigma));
    one.set([points.map(([time]) => time / 1000), bound(1), bound(-1), points.map(([, offset]) => offset)]);
  };
  const day = (row: number) => (times[row] === undefined ? '' : new Intl.DateTimeFormat('en-GB', { month: '2-digit', day: '2-digit' }).format(times[row]));
  const map = heatView({ label: t('drift_map_label'), matrix, across: indexSide(t('sensor'), sensorCount), down: { ...indexSide(t('scans_down'), times.length, day), least: Math.min(4, times.length) }, colours: 'diverging', range, unit: 'mm', height: 340, pick });
  ends.add(one.dispose);
  ends.add(map.dispose);
  const worst = drift.alarms.find((each) => each.sensor !== undefined)?.sensor ?? mostMoved(matrix.values, times.length);
  pick(times.length - 1, worst);
  return [h('section', { class: 'card stack' }, h('h2', null, t('drift_map')), map.root), h('section', { class: 'card stack' }, title, one.root)];
}

function valueText(value: number | undefined, timeMs: number | undefined): string {
  const text = value === undefined || Number.isNaN(value) ? '–' : `${value > 0 ? '+' : ''}${quantity(value, 3, 'mm')}`;
  return `${text} (${timeText(timeMs)})`;
}

function mostMoved(values: Float32Array, rows: number): number {
  const last = Array.from(values.subarray((rows - 1) * sensorCount), (one) => (Number.isNaN(one) ? 0 : Math.abs(one)));
  return last.indexOf(Math.max(...last));
}

function checkCard(check: Drift['reference_check']): HTMLElement {
  if (!check) return card(t('daily_check'), h('p', null, t('no_daily_check')));
  const { passed } = check;
  const findings = check.findings.map((finding, k) => h('p', { class: 'note bad' }, h('strong', null, `▲ ${finding}`), check.advice[k] ? h('br') : null, check.advice[k]));
  return card(
    t('daily_check'),
    h('p', { class: passed ? 'note good' : 'note bad' }, passed ? `✓ ${t('check_passed')}` : `▲ ${t('check_failed')}`, ` · ${timeText(check.time_ms)} · ${t('common_error', { mm: check.common_mm.toFixed(3) })}`),
    ...findings,
    h('details', null, h('summary', null, t('all_values')), jsonView(check)),
  );
}
