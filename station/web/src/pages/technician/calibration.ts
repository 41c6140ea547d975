// Guided calibration: which target, where it stands, scan, how well the ring is known by now, the verdict.
import { get, post } from '../../core/api';
import { booth } from '../../core/booth';
import { h, replace } from '../../core/dom';
import { dialog } from '../../core/overlay';
import { session } from '../../core/session';
import { button, choice, failurePanel, field, showAtField, showFailure, table } from '../../core/ui';
import { ifEnglish } from '../../core/words';
import { t } from '../../words/technician';
import { resultCard } from './calibration_result';
import { type Calibration, type CalibrationRun, type PastCalibration, underWay } from './calibration_run';
import { CalibrationSteps } from './calibration_steps';
import { jobPanel } from './job_panel';
import type { Job } from '../../core/contract';
import { targetsName } from './target_place';
import { badge, card, Ends, pageOf, quantity, terms, timeText } from './page_parts';
import './technician.css';

const askEveryMs = 1000;

export const calibrationPage = {
  mount(root: HTMLElement): () => void {
    const view = new CalibrationView();
    view.show(root);
    return () => view.ends.end();
  },
};

class CalibrationView {
  readonly ends = new Ends();
  readonly #body = h('div', { class: 'stack' });
  readonly #panel = jobPanel(t('solving'));
  #steps: CalibrationSteps | null = null;
  #shownRun = '';
  #state: Calibration | null = null;
  #asking = false;

  show(root: HTMLElement): void {
    pageOf(root, t('calibration_title'), this.#panel.root, this.#body);
    this.ends.add(this.#panel.dispose);
    this.ends.add(() => this.#steps?.dispose());
    // Scans of targets are the booth's: what it says about them comes with its state, the rest is asked for.
    const timer = setInterval(() => {
      if (this.#state?.run && ['scanning', 'solving'].includes(this.#state.run.state)) void this.refresh();
    }, askEveryMs);
    this.ends.add(() => clearInterval(timer));
    this.ends.add(booth.watch(() => this.#steps?.drawBooth()));
    void this.refresh();
  }

  async refresh(): Promise<void> {
    if (this.#asking) return;
    this.#asking = true;
    try {
      this.#state = await get<Calibration>('/api/calibration');
      this.#draw();
    } catch (error) {
      replace(this.#body, failurePanel(error, () => void this.refresh()));
      this.#shownRun = '';
    } finally {
      this.#asking = false;
    }
  }

  #draw(): void {
    const now = this.#state!;
    if (!underWay(now.run)) {
      this.#steps?.dispose();
      this.#steps = null;
      this.#shownRun = '';
      replace(this.#body, inForce(now.current), beginCard(now, (run) => this.#take(run)), historyTable(now.history));
      return;
    }
    if (this.#shownRun !== now.run.id || !this.#steps) {
      this.#steps?.dispose();
      this.#steps = new CalibrationSteps({ take: (step) => this.#takeStep(step), solve: () => this.#solve(), abandon: () => this.#abandon() });
      this.#shownRun = now.run.id;
      replace(this.#body, this.#steps.root);
    }
    this.#steps.draw(now.run, now.run.result ? resultCard(now.run.result, { accept: () => this.#accept(), abandon: () => this.#abandon() }) : null);
  }

  #take(run: CalibrationRun): void {
    this.#state = { ...this.#state!, run };
    this.#draw();
  }

  async #takeStep(step: number): Promise<void> {
    this.#take(await post<CalibrationRun>('/api/calibration/take', { step }));
  }

  async #solve(): Promise<void> {
    try {
      await this.#panel.run(() => post<Job<unknown>>('/api/calibration/solve'));
    } finally {
      await this.refresh();
    }
  }

  async #abandon(): Promise<void> {
    const answer = await dialog(t('abandon_title'), [h('p', null, t('abandon_explain'))], [
      { answer: 'no', text: t('go_on') },
      { answer: 'yes', text: t('abandon'), kind: 'danger' },
    ]);
    if (answer !== 'yes') return;
    await post('/api/calibration/abandon');
    await this.refresh();
  }

  async #accept(): Promise<void> {
    const answer = await dialog(t('accept_title'), [h('p', null, t('accept_explain'))], [
      { answer: 'no', text: t('not_yet') },
      { answer: 'yes', text: t('accept'), kind: 'primary' },
    ]);
    if (answer !== 'yes') return;
    await post('/api/calibration/accept', { confirm: true });
    await this.refresh();
  }
}

function inForce(current: PastCalibration | null): HTMLElement {
  if (!current) return card(t('in_force'), h('p', { class: 'note warn' }, t('none_in_force')));
  return card(t('in_force'), terms([[t('name'), current.name], [t('made'), timeText(current.made_ms)], [t('verdict'), verdictBadge(current.verdict)], [t('sigma_common'), quantity(current.sigma_common_mm, 3, 'mm')]]), reportLink(current.name));
}

function verdictBadge(verdict: string): HTMLElement {
  if (verdict === 'pass' || verdict === 'passed') return badge(`✓ ${t('passed')}`, 'good');
  return badge(verdict === 'fail' || verdict === 'failed' ? `▲ ${t('failed')}` : verdict, verdict.startsWith('fail') ? 'bad' : '');
}

function reportLink(name: string): HTMLElement {
  return h('p', null, h('a', { class: 'button', href: `/api/calibration/report/${encodeURIComponent(name)}`, target: '_blank', rel: 'noopener' }, t('report')));
}

/** The target of the booth's plan, or one described by hand; one board alone if only that was replaced. */
function beginCard(now: Calibration, begun: (run: CalibrationRun) => void): HTMLElement {
  const targets = now.targets.map((one) => (typeof one === 'string' ? { spec: one, name: '' } : one)).map(({ spec, name }) => ({ spec, name: ifEnglish(name) || targetsName(spec) }));
  const own = 'own';
  const target = choice(t('target'), 'target', [...targets.map((one) => [one.spec, one.name] as const), [own, t('target_own')] as const], targets[0]?.spec ?? own);
  const spec = field(t('target_spec'), 'target', { value: 'cylinder:radius_mm=150,u_mm=0.02', hint: t('target_spec_hint') });
  const board = field(t('one_board'), 'board', { hint: t('one_board_hint'), inputmode: 'numeric' });
  const showSpec = () => (spec.root.hidden = target.input.value !== own);
  target.input.addEventListener('change', showSpec);
  showSpec();
  const begin = async () => {
    const wanted = target.input.value === own ? spec.value : target.input.value;
    try {
      begun(await post<CalibrationRun>('/api/calibration/begin', { target: wanted, ...(board.value ? { board: board.value } : {}) }));
    } catch (error) {
      if (!showAtField(error, [spec, board])) showFailure(error);
    }
  };
  const local = session.value?.local !== false;
  return card(
    t('new_calibration'),
    h('p', null, t('calibration_explain')),
    h('div', { class: 'columns' }, h('div', { class: 'stack' }, target.root, spec.root), board.root),
    local ? null : h('p', { class: 'note warn' }, t('only_local')),
    h('div', { class: 'row' }, button(t('begin'), begin, { kind: 'primary', large: true, disabled: !local })),
  );
}

function historyTable(history: readonly PastCalibration[]): HTMLElement {
  if (history.length === 0) return h('p', { class: 'muted' }, t('no_calibrations_yet'));
  return table(
    t('calibration_history'),
    [
      { head: t('name'), cell: (one: PastCalibration) => one.name },
      { head: t('made'), cell: (one) => timeText(one.made_ms) },
      { head: t('verdict'), cell: (one) => verdictBadge(one.verdict) },
      { head: t('sigma_common'), cell: (one) => quantity(one.sigma_common_mm, 3, 'mm'), number: true },
      { head: t('report'), cell: (one) => reportLink(one.name) },
    ],
    history,
  ).root;
}
