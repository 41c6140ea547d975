// A calibration under way: its steps, the one that is due with its drawing, and how the knowledge grows.
import { booth } from '../../core/booth';
import { h, replace } from '../../core/dom';
import { button } from '../../core/ui';
import { plot } from '../../charts/plot';
import { t } from '../../words/technician';
import { allTaken, type CalibrationRun, type CalibrationStep, growth } from './calibration_run';
import { badge, card, quantity } from './page_parts';
import { targetPicture } from './target_picture';
import { placementText } from './target_place';

interface Orders {
  take(step: number): Promise<void>;
  solve(): Promise<void>;
  abandon(): Promise<void>;
}

export class CalibrationSteps {
  readonly root = h('div', { class: 'stack' });
  readonly #list = h('ol', { class: 'calibration-steps', 'aria-label': t('steps') });
  readonly #now = h('div', { class: 'stack', 'aria-live': 'polite' });
  readonly #boothLine = h('p', { class: 'muted', role: 'status' });
  readonly #result = h('div', null);
  readonly #knowledge = plot({
    label: t('knowledge_label'),
    xLabel: t('step'),
    yLabel: t('common_mm'),
    xWhole: true,
    yAtLeast: [0, 0.3],
    height: 230,
    curves: [
      { label: t('predicted'), colour: '--accent', unit: 'mm', digits: 3 },
      { label: t('budget'), colour: '--bad', dashed: true, unit: 'mm', digits: 3 },
    ],
  });
  readonly #residuals = plot({
    label: t('residual_label'),
    xLabel: t('step'),
    yLabel: t('residual_mm'),
    xWhole: true,
    yAtLeast: [0, 0.5],
    height: 230,
    curves: [{ label: t('residual'), colour: '--accent', pointsOnly: true, unit: 'mm', digits: 3 }],
  });
  /** The step that somebody wants to see or repeat; null: the one that is due. */
  #chosen: number | null = null;
  #run: CalibrationRun | null = null;
  #drawn = '';

  constructor(private readonly orders: Orders) {
    replace(
      this.root,
      this.#result,
      h('div', { class: 'calibration-layout' }, h('div', { class: 'card stack' }, h('h2', null, t('steps')), this.#list, button(t('abandon'), () => orders.abandon(), { kind: 'danger' })), h('div', { class: 'stack' }, this.#now, card(t('knowledge'), this.#knowledge.root), card(t('residuals'), this.#residuals.root))),
    );
  }

  dispose(): void {
    this.#knowledge.dispose();
    this.#residuals.dispose();
  }

  draw(run: CalibrationRun, result: HTMLElement | null): void {
    const key = JSON.stringify(run);
    if (key === this.#drawn) return;
    this.#drawn = key;
    if (this.#run?.step !== run.step || this.#run.state !== run.state) this.#chosen = null;
    this.#run = run;
    replace(this.#result, result);
    this.#drawSteps();
    this.#drawNow();
    const { steps, residual, predicted, budget } = growth(run);
    this.#knowledge.set([steps, predicted, budget]);
    this.#residuals.set([steps, residual]);
  }

  /** While a target is scanned the booth says how far it is. */
  drawBooth(): void {
    const { plain, status } = booth.value;
    const share = status && status.total > 0 ? ` ${Math.round((100 * status.done) / status.total)} %` : '';
    this.#boothLine.textContent = `${t('booth_says')} ${plain?.state_text ?? status?.state ?? '–'}${status?.stage ? ` · ${status.stage}` : ''}${share}`;
  }

  #drawSteps(): void {
    const run = this.#run!;
    const shown = this.#chosen ?? run.step;
    const entry = (step: CalibrationStep, k: number) =>
      h(
        'li',
        null,
        h(
          'button',
          { type: 'button', class: 'step', 'aria-current': k === shown ? 'step' : null, onclick: () => this.#choose(k) },
          h('span', { class: 'step-name' }, `${k + 1}. ${step.picture ? shortName(step) : step.what}`),
          h('span', { class: 'row small' }, stepBadge(step, run), step.residual_mm === null || step.residual_mm === undefined ? null : h('span', { class: 'number' }, quantity(step.residual_mm, 3, 'mm')), step.seconds === null || step.seconds === undefined ? null : h('span', { class: 'number' }, `${step.seconds.toFixed(0)} s`)),
        ),
      );
    replace(this.#list, ...run.steps.map(entry));
  }

  #choose(step: number): void {
    this.#chosen = step;
    this.#drawSteps();
    this.#drawNow();
  }

  #drawNow(): void {
    const run = this.#run!;
    const at = this.#chosen ?? run.step;
    const step = run.steps[at];
    if (!step) return replace(this.#now);
    const busy = run.state === 'scanning' || run.state === 'solving';
    const problems = (step.problems ?? []).map((text) => h('p', { class: 'note warn' }, `▲ ${text}`));
    const failure = run.error ? [h('p', { class: 'note bad' }, h('strong', null, `▲ ${run.error.seen}`), h('br'), run.error.advice)] : [];
    this.drawBooth();
    replace(
      this.#now,
      card(
        t('step_of', { n: at + 1, of: run.steps.length }),
        step.picture ? targetPicture(step.picture, step.found ?? null) : h('p', { class: 'large-text' }, step.what),
        step.picture ? h('p', { class: 'muted' }, step.what) : null,
        run.message ? h('p', { class: 'note' }, run.message) : null,
        ...failure,
        ...problems,
        busy ? h('p', { class: 'row' }, badge(run.state === 'scanning' ? t('being_scanned') : t('solving'), 'warn')) : null,
        busy ? this.#boothLine : null,
        this.#buttons(run, step, at, busy),
      ),
    );
  }

  #buttons(run: CalibrationRun, step: CalibrationStep, at: number, busy: boolean): HTMLElement {
    const again = step.state === 'taken' || step.state === 'again' || step.state === 'failed';
    const ready = allTaken(run);
    return h(
      'div',
      { class: 'row' },
      run.result ? null : button(again ? t('repeat') : t('stands_scan'), () => this.orders.take(at), { kind: again && ready ? 'plain' : 'primary', large: !again || !ready, disabled: busy }),
      ready && !run.result ? button(t('solve'), () => this.orders.solve(), { kind: 'primary', large: true, disabled: busy }) : null,
    );
  }
}

/** The place without the target's name: the list is narrow. */
function shortName(step: CalibrationStep): string {
  return placementText({ ...step.picture!, turn_deg: null }) + (step.picture!.verify ? ` (${t('verifies')})` : '');
}

function stepBadge(step: CalibrationStep, run: CalibrationRun): HTMLElement {
  if (step.state === 'taken') return badge(`✓ ${t('step_taken')}`, 'good');
  if (step.state === 'again') return badge(`↻ ${t('step_again')}`, 'warn');
  if (step.state === 'failed') return badge(`▲ ${t('step_failed')}`, 'bad');
  if (step.state === 'now') return badge(run.state === 'scanning' ? t('being_scanned') : t('step_now'), 'warn');
  return badge(t('step_open'));
}
