// The body as it grows: neutral, veiled until the person agrees, with coverage, levels and time left beside it.
import { booth, type BoothStatus } from '../../core/booth';
import { h, replace } from '../../core/dom';
import { fixed } from '../../core/format';
import { on, type LiveMessage } from '../../core/live';
import { dialog } from '../../core/overlay';
import { button, progress } from '../../core/ui';
import { tOperator as t } from '../../words/operator';
import { CoverageMap } from '../../view3d/coverage_map';
import type { GrowingBody } from '../../view3d/growing_body';
import type { LevelRing } from '../../view3d/ring_surface';
import { visit } from './visit';

const kUsualRing_mm = 600;
const kUsualRange = { low_mm: 0, high_mm: 2100 };

export function growth() {
  const picture = h('div', { class: 'growth-view' });
  const axis = booth.value.booth?.axis;
  const coverage = new CoverageMap(t('grow_coverage'), axis ? { low_mm: axis.z_min_mm, high_mm: axis.z_max_mm } : kUsualRange);
  const bar = progress(t('grow_progress'));
  const facts = h('dl', { class: 'facts' });
  const waiting: LevelRing[] = [];
  const pace = new Pace();
  let body: GrowingBody | null = null;
  let drop: () => void = () => {};
  let ended = false;
  let levels = 0;

  const take = (message: LiveMessage) => {
    const level = message as unknown as LevelRing;
    levels += 1;
    coverage.add(level);
    if (body) body.add(level);
    else waiting.push(level);
  };
  const stopListening = on('level', take);
  void openView(picture).then((view) => {
    if (ended) return view.dispose();
    drop = view.dispose;
    body = view.body;
    for (const level of waiting.splice(0)) body.add(level);
    if (clear) body.show('clear');
  });

  let clear = false;
  const showButton = button(t('grow_show'), async () => {
    if (!clear && !(await customerAgrees())) return;
    clear = !clear;
    body?.show(clear ? 'clear' : 'veiled');
    showButton.textContent = clear ? t('grow_hide') : t('grow_show');
  });

  const root = h(
    'div',
    { class: 'growth' },
    h('div', { class: 'stack' }, picture, h('div', { class: 'row spread' }, h('p', { class: 'muted small' }, t('grow_veil')), showButton)),
    h('div', { class: 'stack' }, bar.root, facts, h('div', null, h('h3', null, t('grow_coverage')), coverage.element, h('p', { class: 'muted small' }, t('grow_coverage_text')))),
  );
  const fact = (name: string, value: string) => [h('dt', null, name), h('dd', { class: 'number' }, value)];
  return {
    root,
    follow(status: BoothStatus) {
      const left = pace.secondsLeft(status.stage, status.done, status.total);
      bar.set(status.total > 0 ? status.done / status.total : null);
      replace(facts, ...fact(t('grow_levels'), String(levels)), ...fact(t('grow_left'), left === null ? '…' : t('seconds', { n: left })), ...fact(t('grow_seen'), `${fixed(100 * coverage.share, 0)} %`), ...fact(t('grow_height'), `${fixed(status.z_mm / 10, 0)} cm`));
    },
    finished() {
      bar.set(1);
    },
    dispose() {
      ended = true;
      stopListening();
      drop();
    },
  };
}

/** Asked aloud, answered by the operator. */
async function customerAgrees(): Promise<boolean> {
  const answer = await dialog(t('grow_ask'), [h('p', null, t('grow_ask_text'))], [
    { answer: 'no', text: t('cancel') },
    { answer: 'yes', text: t('grow_ask_yes'), kind: 'primary' },
  ]);
  return answer === 'yes';
}

/** Fetches three.js while the customer gets ready, so that the first level finds it. */
export function prepareGrowth() {
  return Promise.all([import('../../view3d/viewer'), import('../../view3d/growing_body')]);
}

/** Levels that arrive before it is there are kept. */
async function openView(host: HTMLElement) {
  const [{ Viewer }, { GrowingBody: Body }] = await prepareGrowth();
  const viewer = new Viewer(host, { label: t('grow_view'), unavailable: t('grow_no_view') });
  const body = new Body(viewer, booth.value.booth?.ring_radius_mm ?? kUsualRing_mm, visit.value.profile === 'head' ? 'head' : 'body');
  return {
    body,
    dispose() {
      body.dispose();
      viewer.dispose();
    },
  };
}

/** How long the rest takes, from how fast the stage has gone so far. */
class Pace {
  #stage = '';
  #from = { done: 0, at_ms: 0 };

  secondsLeft(stage: string, done: number, total: number): number | null {
    const now_ms = performance.now();
    if (stage !== this.#stage || done < this.#from.done) {
      this.#stage = stage;
      this.#from = { done, at_ms: now_ms };
    }
    const gone = done - this.#from.done;
    const passed_ms = now_ms - this.#from.at_ms;
    if (gone <= 0 || passed_ms < 500) return null;
    return Math.max(0, Math.ceil(((total - done) * passed_ms) / gone / 1000));
  }
}
