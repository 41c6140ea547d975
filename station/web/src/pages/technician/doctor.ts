// `annulus doctor` from the page: computer, buses, devices. Nothing moves.
import { post } from '../../core/api';
import { booth, moves } from '../../core/booth';
import { h, replace } from '../../core/dom';
import { button, table } from '../../core/ui';
import { t } from '../../words/technician';
import { JobCancelled, jobPanel } from './job_panel';
import type { Job } from '../../core/contract';
import { badge, card, Ends, pageOf, timeText } from './page_parts';
import './technician.css';

interface DoctorItem {
  group: string;
  name: string;
  verdict: 'ok' | 'none' | 'problem';
  seen: string;
  advice: string;
}

interface DoctorReport {
  config: string;
  healthy: boolean;
  items: DoctorItem[];
}

export const doctorPage = {
  mount(root: HTMLElement): () => void {
    const ends = new Ends();
    const panel = jobPanel(t('doctor_runs'));
    const report = h('div', { class: 'stack', 'aria-live': 'polite' });
    const run = button(t('doctor_run'), () => examine(panel, report), { kind: 'primary', large: true });
    const busy = h('p', { class: 'note warn' }, t('doctor_not_now'));
    ends.add(panel.dispose);
    ends.add(booth.watch((view) => (busy.hidden = !moves(view))));
    pageOf(root, t('doctor_title'), h('p', null, t('doctor_explain')), busy, h('p', { class: 'row' }, run), panel.root, report);
    return () => ends.end();
  },
};

async function examine(panel: ReturnType<typeof jobPanel>, into: HTMLElement): Promise<void> {
  try {
    const report = await panel.run<DoctorReport>(() => post<Job<DoctorReport>>('/api/technician/doctor'));
    replace(into, ...drawn(report));
  } catch (error) {
    if (!(error instanceof JobCancelled)) replace(into);
  }
}

function drawn(report: DoctorReport): Node[] {
  const problems = report.items.filter((item) => item.verdict === 'problem');
  const summary = report.healthy
    ? h('p', { class: 'note good' }, `✓ ${t('doctor_healthy', { n: report.items.length })}`)
    : h('p', { class: 'note bad' }, `▲ ${t('doctor_problems', { n: problems.length })}`);
  const groups = [...new Set(report.items.map((item) => item.group))];
  return [
    summary,
    h('p', { class: 'muted small' }, t('doctor_of', { config: report.config, time: timeText(Date.now()) })),
    ...problems.map((item) => card(`▲ ${item.group}: ${item.name}`, h('p', null, item.seen), h('p', null, h('strong', null, item.advice)))),
    ...groups.map((group) => groupTable(group, report.items.filter((item) => item.group === group))),
  ];
}

function groupTable(group: string, items: readonly DoctorItem[]): HTMLElement {
  const verdict = { ok: () => badge(t('verdict_ok'), 'good'), none: () => badge(t('verdict_none')), problem: () => badge(`▲ ${t('verdict_problem')}`, 'bad') };
  const names: Record<string, string> = { host: t('group_host'), buses: t('group_buses'), ring: t('group_ring'), axis: t('axis'), interlock: t('interlock') };
  const made = table(
    names[group] ?? group,
    [
      { head: t('what'), cell: (item: DoctorItem) => item.name },
      { head: t('verdict'), cell: (item) => verdict[item.verdict]() },
      { head: t('seen'), cell: (item) => (item.advice ? [item.seen, h('br'), h('strong', null, `→ ${item.advice}`)] : item.seen) },
    ],
    items,
  ).root;
  made.classList.add('doctor-group');
  return made;
}
