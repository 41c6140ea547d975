// Fit options tried live: two fits of the same recording beside each other.
import { post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { button, choice, field, showAtField } from '../../core/ui';
import { t } from '../../words/developer';
import { JobCancelled, jobPanel } from '../technician/job_panel';
import type { Job } from '../../core/contract';
import { jsonView } from '../technician/json_view';
import { card } from '../technician/page_parts';
import { type FitReport, fitRows, optionsOf, pictureSource } from './fit_report';
import type { OpenReplay } from './replay_file';

type Side = 'a' | 'b';

export class FitsPanel {
  readonly root = h('div', { class: 'stack' });
  readonly #sides: Record<Side, FitSide>;
  readonly #numbers = h('div', { 'aria-live': 'polite' });
  readonly #compared = h('div', { 'aria-live': 'polite' });
  readonly #compare = button(t('compare'), () => this.#runCompare(), { kind: 'primary', disabled: true });

  constructor(private readonly replay: OpenReplay) {
    this.#sides = { a: new FitSide(replay, 'A', 'adaptive', () => this.#draw()), b: new FitSide(replay, 'B', 'uniform', () => this.#draw()) };
    replace(this.root, h('p', null, t('fits_explain')), h('div', { class: 'columns' }, this.#sides.a.root, this.#sides.b.root), this.#numbers, h('div', { class: 'row' }, this.#compare), this.#compared);
  }

  dispose(): void {
    this.#sides.a.dispose();
    this.#sides.b.dispose();
  }

  #draw(): void {
    const [a, b] = [this.#sides.a.report, this.#sides.b.report];
    this.#compare.disabled = !a || !b;
    replace(this.#compared);
    if (!a && !b) return replace(this.#numbers);
    const number = (value: number | null) => (value === null ? '–' : (Number.isInteger(value) ? String(value) : value.toPrecision(4)).replace('-', '−'));
    const cells = fitRows(a, b).map(({ key, name, a: left, b: right }) => h('tr', null, h('th', { scope: 'row' }, name ?? t(key as Parameters<typeof t>[0])), h('td', { class: 'number' }, number(left)), h('td', { class: 'number' }, number(right)), h('td', { class: 'number' }, left !== null && right !== null ? number(right - left) : '–')));
    const head = h('tr', null, h('th', { scope: 'col' }, t('number')), h('th', { scope: 'col', class: 'number' }, 'A'), h('th', { scope: 'col', class: 'number' }, 'B'), h('th', { scope: 'col', class: 'number' }, 'B − A'));
    replace(this.#numbers, h('div', { class: 'table-frame', tabindex: 0, role: 'region', 'aria-label': t('numbers') }, h('table', null, h('caption', null, t('numbers')), h('thead', null, head), h('tbody', null, cells))));
  }

  async #runCompare(): Promise<void> {
    const [a, b] = [this.#sides.a.report, this.#sides.b.report];
    if (!a || !b) return;
    const answer = await post<object>(`/api/replay/${this.replay.replay_id}/compare`, { a: a.model_id, b: b.model_id });
    replace(this.#compared, card(t('compared'), jsonView(answer)));
  }
}

class FitSide {
  readonly root: HTMLElement;
  report: FitReport | null = null;
  readonly #panel = jobPanel(t('fitting'));
  readonly #picture = h('div', { class: 'stack' });
  readonly #method;
  readonly #theta = field(t('theta_knots'), 'theta_knots', { type: 'number', min: 0, step: 1, hint: t('knots_hint', { n: 48 }) });
  readonly #z = field(t('z_knots'), 'z_knots', { type: 'number', min: 0, step: 1, hint: t('knots_hint', { n: 117 }) });

  constructor(
    private readonly replay: OpenReplay,
    private readonly name: string,
    method: string,
    private readonly changed: () => void,
  ) {
    this.#method = choice(t('method'), 'method', [['adaptive', t('method_adaptive')], ['uniform', t('method_uniform')], ['paper', t('method_paper')]], method);
    const knots = h('div', { class: 'knots' }, this.#theta.root, this.#z.root);
    const show = () => (knots.hidden = this.#method.input.value !== 'uniform');
    this.#method.input.addEventListener('change', show);
    show();
    this.root = card(t('fit_n', { n: name }), this.#method.root, knots, h('div', { class: 'row' }, button(t('run_fit', { n: name }), () => this.#run(), { kind: 'primary' })), this.#panel.root, this.#picture);
  }

  dispose(): void {
    this.#panel.dispose();
  }

  async #run(): Promise<void> {
    const options = optionsOf(this.#method.input.value, this.#theta.value, this.#z.value);
    try {
      this.report = await this.#panel.run<FitReport>(() => post<Job<FitReport>>(`/api/replay/${this.replay.replay_id}/fit`, { options }));
      const source = pictureSource(this.report);
      replace(this.#picture, source ? h('img', { src: source, class: 'residual-picture', alt: t('residual_picture', { n: this.name }) }) : null, h('details', null, h('summary', null, t('whole_report')), jsonView({ ...this.report, residuals_png: undefined })));
      this.changed();
    } catch (error) {
      showAtField(error, [this.#theta, this.#z]);
      if (!(error instanceof JobCancelled)) replace(this.#picture);
    }
  }
}
