// The section at a level that is drawn up and down: tape girth, outline, area.
import { h } from '../../core/dom';
import { tMeasure } from '../../words/measure';
import { sliderRow } from '../glasses/controls';
import { NewestOnly } from '../glasses/newest_only';
import type { Section, SectionQuestion } from './api';
import { LevelHandle } from './level_handle';
import { intervalText } from './numbers';
import { lineColours, Results, type Bench, type Tool } from './tool';

export function levelTool(bench: Bench): Tool {
  const { viewer, api } = bench;
  let open = false;
  let question: SectionQuestion = { z_mm: Math.round((bench.low_mm + 2 * bench.high_mm) / 3) };
  const results = new Results();
  const feed = new NewestOnly((one: SectionQuestion) => api.section(one), (answer) => show(answer), (error) => results.fail(error));
  const change = (next: Partial<SectionQuestion>): void => {
    question = { ...question, ...next };
    height.set(question.z_mm);
    handle.show(question.z_mm);
    feed.ask(question);
  };
  const settled = (): void => {};
  const height = sliderRow(tMeasure('height'), { low: Math.ceil(bench.low_mm), high: Math.floor(bench.high_mm), step: 0.5, unit: 'mm' }, (z_mm) => change({ z_mm }), settled);
  const angle = { low: -45, high: 45, step: 0.5, unit: '°' };
  const tilt = sliderRow(tMeasure('tilt'), angle, (tilt_deg) => change({ tilt_deg }), settled);
  const lean = sliderRow(tMeasure('lean'), angle, (lean_deg) => change({ lean_deg }), settled);
  tilt.set(0);
  lean.set(0);
  const handle = new LevelHandle(bench, 'level.handle', tMeasure('level_handle'), '⇕', (z_mm) => change({ z_mm }));
  const show = (answer: Section): void => {
    if (!open) return;
    viewer.clear('level.line');
    answer.loops.forEach((loop, i) => viewer.setLine(`level.line${i}`, loop, { colour: lineColours.main, width_px: 3, through: true }));
    viewer.setLine('level.line.tape', answer.tape, { colour: lineColours.second, width_px: 3, through: true });
    results.show([
      { term: tMeasure('tape_girth'), value: intervalText(answer.tape_mm, answer.tape_sigma_mm, 'mm'), note: tMeasure('measured', { share: Math.round(100 * answer.measured_share) }) },
      { term: tMeasure('perimeter'), value: intervalText(answer.perimeter_mm, answer.perimeter_sigma_mm, 'mm') },
      { term: tMeasure('section_area'), value: intervalText(answer.area_mm2, answer.area_sigma_mm2, 'mm2') },
    ], tMeasure('level_note'));
  };
  return {
    root: h('div', { class: 'stack' }, height.root, results.root, h('details', { class: 'more' }, h('summary', null, tMeasure('tilted')), tilt.root, lean.root)),
    begin: () => {
      open = true;
      handle.begin();
      change({});
    },
    end: () => {
      open = false;
      handle.end();
      viewer.clear('level.');
    },
  };
}
