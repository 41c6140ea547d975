// Volume and surface between two levels (paper 001, §3.1, §3.2).
import { h } from '../../core/dom';
import { tMeasure } from '../../words/measure';
import { sliderRow } from '../glasses/controls';
import { NewestOnly } from '../glasses/newest_only';
import { LevelHandle } from './level_handle';
import { intervalText } from './numbers';
import { lineColours, Results, type Bench, type Tool } from './tool';

interface Levels {
  low: number;
  high: number;
}

/** Planes nearer than this (mm) hold nothing worth saying. */
const thinnest_mm = 1;

export function slabTool(bench: Bench): Tool {
  const { viewer, api, low_mm, high_mm } = bench;
  let open = false;
  let levels: Levels = { low: Math.round(low_mm + 0.45 * (high_mm - low_mm)), high: Math.round(low_mm + 0.7 * (high_mm - low_mm)) };
  const results = new Results();
  const feed = new NewestOnly(async ({ low, high }: Levels) => {
    const [slab, below, above] = await Promise.all([api.slab(low, high), api.section({ z_mm: low }), api.section({ z_mm: high })]);
    return { slab, loops: [...below.loops, ...above.loops] };
  }, ({ slab, loops }) => {
    if (!open) return;
    viewer.clear('slab.line');
    loops.forEach((loop, i) => viewer.setLine(`slab.line${i}`, loop, { colour: lineColours.main, width_px: 3, through: true }));
    results.show([
      { term: tMeasure('volume'), value: intervalText(slab.volume_mm3, slab.volume_sigma_mm3, 'mm3') },
      { term: tMeasure('skin_area'), value: intervalText(slab.area_mm2, slab.area_sigma_mm2, 'mm2') },
    ], tMeasure('slab_note'));
  }, (error) => results.fail(error));
  /** The plane that is moved pushes the other one before it. */
  const change = (next: Partial<Levels>): void => {
    const merged = { ...levels, ...next };
    if (merged.high - merged.low < thinnest_mm) {
      if (next.low !== undefined) merged.high = Math.min(high_mm, merged.low + thinnest_mm);
      else merged.low = Math.max(low_mm, merged.high - thinnest_mm);
      if (merged.high - merged.low < thinnest_mm) return;
    }
    levels = merged;
    low.set(levels.low);
    high.set(levels.high);
    handles.low.show(levels.low);
    handles.high.show(levels.high);
    feed.ask(levels);
  };
  const range = { low: Math.ceil(low_mm), high: Math.floor(high_mm), step: 0.5, unit: 'mm' };
  const high = sliderRow(tMeasure('upper_plane'), range, (value) => change({ high: value }), () => {});
  const low = sliderRow(tMeasure('lower_plane'), range, (value) => change({ low: value }), () => {});
  const handles = {
    high: new LevelHandle(bench, 'slab.high', tMeasure('upper_plane'), '↥', (value) => change({ high: value })),
    low: new LevelHandle(bench, 'slab.low', tMeasure('lower_plane'), '↧', (value) => change({ low: value })),
  };
  return {
    root: h('div', { class: 'stack' }, high.root, low.root, results.root),
    begin: () => {
      open = true;
      handles.high.begin();
      handles.low.begin();
      change({});
    },
    end: () => {
      open = false;
      handles.high.end();
      handles.low.end();
      viewer.clear('slab.');
    },
  };
}
