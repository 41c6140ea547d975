// How the frame sits, in words and numbers, and the files that leave the shop.
import { h, replace } from '../../core/dom';
import { button, failurePanel, field, progress, table, type Column } from '../../core/ui';
import { ifEnglish } from '../../core/words';
import { toast } from '../../core/overlay';
import { contactWord, tGlasses, goalWords } from '../../words/glasses';
import type { Artefact, Contact, FitReport, Goal } from './api';
import { activeDesign } from './design';
import type { Desk } from './desk';
import { finished } from './jobs';
import { whileOpen, type Panel } from './shape_panel';

export function fitPanel(desk: Desk): Panel {
  const report = h('div', { class: 'stack', 'aria-live': 'polite' });
  const order = orderSection(desk);
  const run = button(tGlasses('fit_run'), () => fitNow(desk, report), { kind: 'primary' });
  const show = (): void => {
    const fitted = desk.fitted.value[desk.side];
    const fresh = desk.fresh(desk.side);
    order.enable(fresh !== null);
    if (!fitted) replace(report, h('p', { class: 'muted' }, tGlasses('fit_first')));
    else replace(report, fresh ? null : h('p', { class: 'note warn' }, tGlasses('expired_fit')), ...reportParts(fitted.report));
  };
  const root = h('div', { class: 'stack' }, run, report, order.root);
  const ends = [desk.bench.watch(whileOpen(root, show)), desk.fitted.watch(show)];
  return { root, show, end: () => ends.forEach((end) => end()) };
}

async function fitNow(desk: Desk, into: HTMLElement): Promise<void> {
  const { side } = desk;
  const { prescription } = desk.bench.value;
  const design = activeDesign(desk.bench.value);
  const bar = progress(tGlasses('fit'));
  replace(into, bar.root);
  try {
    const job = await desk.api.fit(design, prescription);
    const result = await finished<{ worn: Artefact; report: FitReport }>(job, ({ share, stage }) => bar.set(share, ifEnglish(stage)));
    if (result) desk.fitted.set({ ...desk.fitted.value, [side]: { design, prescription, worn: result.worn.id, report: result.report } });
  } catch (error) {
    replace(into, failurePanel(error));
  }
}

function reportParts(report: FitReport): HTMLElement[] {
  const verdict = h('p', { class: `note ${report.wearable ? 'good' : 'warn'}` },
    h('strong', null, tGlasses(report.wearable ? 'fit_good' : 'fit_bad')), ` · ${tGlasses('fit_score', { score: Math.round(report.score) })}`);
  const { frame_g, lenses_g, nose_share } = report.balance;
  const weight = h('p', null, tGlasses('fit_weight', { grams: (frame_g + lenses_g).toFixed(1), lenses: lenses_g.toFixed(1), nose: Math.round(100 * nose_share) }));
  const enters = report.penetration_mm > 0.02 ? h('p', { class: 'note warn' }, tGlasses('fit_enters', { mm: report.penetration_mm.toFixed(2) })) : null;
  return [verdict, ...adviceOf(report), weight, ...(enters ? [enters] : []), goalTable(report.goals), contactTable(report.contacts)];
}

function adviceOf(report: FitReport): HTMLElement[] {
  const own = report.goals.map((goal) => goalWords(goal).advice).filter((text) => text !== '');
  const lines = own.length > 0 ? own : report.advice;
  return lines.length === 0 ? [] : [h('h3', null, tGlasses('advice')), h('ul', { class: 'advice' }, ...lines.map((line) => h('li', null, line)))];
}

function valueOf(goal: Goal): string {
  const interval = goal.sigma === undefined ? '' : ` ± ${(1.96 * goal.sigma).toFixed(1)}`;
  return `${goal.value.toFixed(goal.unit === '%' ? 0 : 1)}${interval} ${goal.unit === 'deg' ? '°' : goal.unit}`;
}

function goalTable(goals: readonly Goal[]): HTMLElement {
  const columns: Column<Goal>[] = [
    { head: tGlasses('fit_what'), cell: (goal) => goalWords(goal).term },
    { head: tGlasses('fit_value'), number: true, cell: (goal) => valueOf(goal) },
    {
      head: tGlasses('fit_range'),
      number: true,
      cell: (goal) => [`${goal.low.toFixed(0)} … ${goal.high > 1e3 ? '' : goal.high.toFixed(0)}`, h('span', { class: `badge ${goal.met ? 'good' : 'bad'}` }, tGlasses(goal.met ? 'fit_yes' : 'fit_no'))],
    },
  ];
  return table(tGlasses('fit_table'), columns, goals).root;
}

function contactTable(contacts: readonly Contact[]): HTMLElement {
  return table(tGlasses('contacts'), [
    { head: tGlasses('contact_part'), cell: (contact: Contact) => contactWord(contact.part) },
    { head: tGlasses('contact_gap'), number: true, cell: (contact) => contact.distance_mm.toFixed(2) },
    { head: tGlasses('contact_load'), number: true, cell: (contact) => `${Math.round(100 * contact.load_share)} %` },
  ], contacts).root;
}

const formats = ['pdf', 'dcs', 'stl', 'step', 'json'] as const;

function orderSection(desk: Desk): { root: HTMLElement; enable(now: boolean): void } {
  const name = field(tGlasses('confirm_name'), 'confirmed_by', { hint: tGlasses('confirm_hint'), maxlength: 80 });
  const links = h('ul', { class: 'files', 'aria-live': 'polite' });
  const buttons = formats.map((format) =>
    button(tGlasses(`export_${format}`), async () => {
      const fitted = desk.fresh(desk.side);
      if (!fitted) return;
      const result = await finished<{ document: Artefact }>(await desk.api.export(fitted.worn, format, name.value));
      if (!result) return;
      const { document: file } = result;
      links.prepend(h('li', null, h('a', { href: `/api/artefacts/${encodeURIComponent(file.id)}`, download: file.name }, file.name)));
      toast(tGlasses('file_ready', { name: file.name }), 'good');
    }));
  return {
    root: h('section', { class: 'stack' }, h('h3', null, tGlasses('order')), name.root, h('div', { class: 'row' }, ...buttons), links),
    enable: (now) => buttons.forEach((one) => (one.disabled = !now)),
  };
}
