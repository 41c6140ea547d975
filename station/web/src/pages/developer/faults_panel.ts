// What the drivers would have done, had this gone wrong on the buses: a fault plan, its run, the verdict.
import { post } from '../../core/api';
import { h, replace } from '../../core/dom';
import { button, choice, field, newId } from '../../core/ui';
import { t } from '../../words/developer';
import { JobCancelled, jobPanel } from '../technician/job_panel';
import type { Job } from '../../core/contract';
import { card, quantity, terms } from '../technician/page_parts';
import { emptyPlan, faultOf, type FaultPlan, isProblem, planText, readPlan, replayKinds } from './fault_plan';
import type { OpenReplay, ReplayOutcome } from './replay_file';

export class FaultsPanel {
  readonly root = h('div', { class: 'stack' });
  readonly #panel = jobPanel(t('replaying'));
  readonly #verdict = h('div', { 'aria-live': 'polite' });
  readonly #problem = h('div', { 'aria-live': 'polite' });
  readonly #id = newId('plan');
  readonly #text = h('textarea', { id: this.#id, class: 'code', rows: 12, wrap: 'off', spellcheck: 'false', 'aria-describedby': `${this.#id}-problem` });
  readonly #kind = choice(t('kind'), 'kind', replayKinds.map((one, k) => [String(k), `${one.target}: ${t(`fault_${one.kind}` as Parameters<typeof t>[0])}`] as const), '0');
  readonly #level = field(t('from_level'), 'level', { type: 'number', min: 0, step: 1, value: '40' });
  readonly #length = field(t('for_seconds'), 'for_s', { type: 'number', min: 0, step: 'any', value: '0.3', hint: t('for_hint') });

  /** `goTo` shows a level; `levelNow` is the one that is shown. */
  constructor(
    private readonly replay: OpenReplay,
    private readonly goTo: (level: number, sensor: number | null) => void,
    private readonly levelNow: () => number,
  ) {
    this.#problem.id = `${this.#id}-problem`;
    this.#text.value = planText(emptyPlan());
    this.#text.addEventListener('input', () => this.#look());
    const add = h(
      'div',
      { class: 'fault-builder' },
      this.#kind.root,
      this.#level.root,
      this.#length.root,
      h('div', { class: 'row' }, button(t('level_shown'), () => (this.#level.input.value = String(this.levelNow()))), button(t('add_fault'), () => this.#add(), { kind: 'primary' })),
    );
    const editor = h('div', { class: 'field' }, h('label', { for: this.#id }, t('plan')), this.#text, this.#problem);
    const runs = h('div', { class: 'row' }, button(t('run_plan'), () => this.#run(this.#text.value), { kind: 'primary', large: true }), button(t('run_plain'), () => this.#run(null)), button(t('clear_plan'), () => this.#put(emptyPlan())));
    replace(this.root, h('p', null, t('faults_explain')), h('div', { class: 'columns' }, h('div', { class: 'stack' }, card(t('new_fault'), add), editor, runs), h('div', { class: 'stack' }, this.#panel.root, this.#verdict)));
  }

  dispose(): void {
    this.#panel.dispose();
  }

  #put(plan: FaultPlan): void {
    this.#text.value = planText(plan);
    this.#look();
  }

  #add(): void {
    const read = readPlan(this.#text.value);
    const kind = replayKinds[Number(this.#kind.input.value)];
    if (isProblem(read) || !kind) {
      this.#look();
      return;
    }
    const level = Math.max(0, Math.round(Number(this.#level.value) || 0));
    this.#put({ ...read, faults: [...read.faults, faultOf(kind, level, Number(this.#length.value) || 0)] });
  }

  /** Says what can be seen to be wrong; false if something is. */
  #look(): boolean {
    const read = readPlan(this.#text.value);
    replace(this.#problem);
    this.#text.removeAttribute('aria-invalid');
    if (!isProblem(read)) return true;
    this.#text.setAttribute('aria-invalid', 'true');
    replace(this.#problem, h('p', { class: 'note bad' }, `▲ ${read.line === null ? '' : `${t('line_n', { n: read.line })}: `}${read.text}`));
    return false;
  }

  async #run(text: string | null): Promise<void> {
    if (text !== null && !this.#look()) return;
    replace(this.#verdict);
    const body = text === null ? {} : { faults: readPlan(text) };
    try {
      const outcome = await this.#panel.run<ReplayOutcome>(() => post<Job<ReplayOutcome>>(`/api/replay/${this.replay.replay_id}/run`, body));
      replace(this.#verdict, this.#drawn(outcome));
    } catch (error) {
      if (error instanceof JobCancelled) return;
    }
  }

  #drawn(outcome: ReplayOutcome): HTMLElement {
    const first = outcome.first_difference;
    const where = first ? [first.level === undefined ? null : t('at_level', { n: first.level }), first.sensor === undefined ? null : t('at_sensor', { n: first.sensor }), first.field].filter(Boolean).join(' · ') : '';
    const list = (title: string, texts: readonly string[]) => (texts.length === 0 ? null : h('div', null, h('h3', null, title), h('ul', null, texts.map((text) => h('li', null, text)))));
    return card(
      t('verdict'),
      outcome.identical ? h('p', { class: 'note good' }, `✓ ${t('identical')}`) : h('p', { class: 'note bad' }, h('strong', null, `▲ ${t('differs')} `), where),
      first ? terms([[t('recorded'), first.recorded], [t('replayed'), first.replayed]]) : null,
      first?.level === undefined ? null : h('p', { class: 'row' }, button(t('show_difference'), () => this.goTo(first.level!, first.sensor ?? null))),
      terms([
        [t('identical_levels'), t('n_of', { n: outcome.identical_levels, of: outcome.recorded_levels })],
        [t('replayed_levels'), String(outcome.replayed_levels)],
        [t('differing'), String(outcome.differing)],
        [t('worst_range'), quantity(outcome.worst_range_mm, 3, 'mm')],
        [t('worst_z'), quantity(outcome.worst_z_mm, 3, 'mm')],
        [t('took'), t('took_text', { scan: outcome.scan_s.toFixed(1), replay: outcome.replay_s.toFixed(2) })],
      ]),
      list(t('happened'), outcome.faults),
      list(t('passed_over'), outcome.faults_passed_over),
    );
  }
}
