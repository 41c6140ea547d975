// All frames of the library, put on this head and ranked.
import { h, replace } from '../../core/dom';
import { button, failurePanel, progress } from '../../core/ui';
import { ifEnglish } from '../../core/words';
import { rankWords, tGlasses, styleWord } from '../../words/glasses';
import type { RankedFrame } from './api';
import { cancelJob, finished } from './jobs';
import type { Desk } from './desk';
import { frameDrawing } from './frame_drawing';
import type { Panel } from './shape_panel';

export function libraryPanel(desk: Desk): Panel {
  const list = h('div', { class: 'stack' }, h('p', { class: 'muted' }, tGlasses('library_first')));
  const run = button(tGlasses('library_run'), () => rankNow(desk, list), { kind: 'primary' });
  return { root: h('div', { class: 'stack' }, run, list), show: () => {}, end: () => {} };
}

async function rankNow(desk: Desk, into: HTMLElement): Promise<void> {
  const bar = progress(tGlasses('library'));
  replace(into, bar.root);
  try {
    const job = await desk.api.rank(desk.bench.value.prescription, 30);
    into.append(button(tGlasses('cancel'), () => cancelJob(job.id)));
    const result = await finished<{ frames: RankedFrame[] }>(job, ({ share, stage }) => bar.set(share, ifEnglish(stage)));
    if (result) replace(into, h('ol', { class: 'ranking' }, ...result.frames.map((frame) => rankedRow(desk, frame))));
    else replace(into, h('p', { class: 'muted' }, tGlasses('library_first')));
  } catch (error) {
    replace(into, failurePanel(error));
  }
}

function rankedRow(desk: Desk, frame: RankedFrame): HTMLElement {
  const style = desk.style(frame.style);
  const name = styleWord(frame.style, style?.name ?? frame.style);
  const drawing = frameDrawing(style?.values ?? {}, { upper: '#4a3426', lower: '#4a3426', lens: '#c5d3de' }, name);
  const take = button(tGlasses('take'), () => {
    desk.changeDesign(tGlasses('step_rank', { name }), null, (design) => ({ ...design, style: frame.style, size: frame.size, fields: {} }));
  }, { label: `${tGlasses('take')}: ${name} ${frame.marking}` });
  return h('li', { class: 'ranked' },
    h('span', { class: 'rank number' }, frame.rank), drawing,
    h('div', null, h('strong', null, name), h('span', { class: 'muted' }, ` ${frame.marking}`),
      h('p', { class: 'small' }, `${tGlasses('fit_score', { score: Math.round(frame.score) })}${frame.why ? ` · ${rankWords(frame)}` : ''}`)),
    take);
}
