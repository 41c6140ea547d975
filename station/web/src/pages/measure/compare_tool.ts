// Two visits of a customer: both bodies from the same side, and what has changed beyond what chance does.
import { h, replace } from '../../core/dom';
import { choice, table, type Column } from '../../core/ui';
import { dateText } from '../../words/glasses';
import { tMeasure } from '../../words/measure';
import { Viewer } from '../../view3d/viewer';
import { curvesOf, MeasureApi, numberOf, type Comparison, type Difference, type Measurement, type Visit } from './api';
import { changeText, sd95, valueText } from './numbers';
import { lineColours, Results, type Bench, type Tool } from './tool';

/** `second`: where the other visit's picture goes while the tool is open. */
export function compareTool(bench: Bench, second: HTMLElement): Tool {
  const results = new Results();
  const list = h('div', { class: 'stack' });
  const pick = h('div');
  let other: Viewer | null = null;
  let unlink = (): void => {};
  let open = false;
  const close = (): void => {
    unlink();
    other?.dispose();
    other = null;
    second.hidden = true;
  };
  const show = async (visit: Visit): Promise<void> => {
    close();
    replace(list);
    results.hint(tMeasure('comparing'));
    try {
      const otherApi = new MeasureApi(visit.id);
      const [mesh, comparison, before, now] = await Promise.all([otherApi.mesh(), bench.api.compare(visit.id), otherApi.measurements(), bench.api.measurements()]);
      if (!open) return;
      second.hidden = false;
      replace(second, h('p', { class: 'booth-date' }, dateOf(visit)));
      const viewer = new Viewer(second, { label: tMeasure('other_view', { date: dateOf(visit) }), unavailable: tMeasure('unavailable') });
      other = viewer;
      viewer.setMesh('body', mesh, { knowledge: true });
      unlink = linked(bench.viewer, viewer);
      viewer.setCamera(bench.viewer.camera(), 'quiet');
      replace(results.root, h('p', null, tMeasure('compare_summary', { n: comparison.differences.filter((one) => one.significant).length, all: comparison.differences.length })));
      replace(list, ...differenceParts(comparison, (id) => {
        showCurve(bench.viewer, now, id);
        showCurve(viewer, before, id);
      }));
    } catch (error) {
      results.fail(error);
    }
  };
  const begin = async (): Promise<void> => {
    open = true;
    results.hint(tMeasure('compare_hint'));
    try {
      const visits = (await bench.api.visits()).filter((visit) => visit.model && visit.id !== bench.api.scan);
      if (!open) return;
      if (visits.length === 0) return results.hint(tMeasure('compare_none'));
      const select = choice(tMeasure('other_visit'), 'other', [['', '–'] as const, ...visits.map((visit) => [visit.id, dateOf(visit)] as const)], '');
      select.input.addEventListener('change', () => {
        const visit = visits.find((one) => one.id === select.input.value);
        if (visit) void show(visit);
        else close();
      });
      replace(pick, select.root);
    } catch (error) {
      results.fail(error);
    }
  };
  return {
    root: h('div', { class: 'stack' }, pick, results.root, list),
    begin: () => void begin(),
    end: () => {
      open = false;
      close();
      replace(list);
      bench.viewer.clear('compare.');
    },
  };
}

function dateOf(visit: Visit): string {
  return dateText(visit.taken_ms);
}

function linked(a: Viewer, b: Viewer): () => void {
  const ends = [a.onCamera((place) => b.setCamera(place, 'quiet')), b.onCamera((place) => a.setCamera(place, 'quiet'))];
  return () => ends.forEach((end) => end());
}

function showCurve(viewer: Viewer, lines: readonly Measurement[], id: string): void {
  viewer.clear('compare.');
  const curves = curvesOf(lines.find((line) => line.id === id));
  curves.forEach((curve, i) => viewer.setLine(`compare.curve${i}`, curve, { colour: lineColours.second, width_px: 4, through: true }));
}

/** The table, what cannot be compared, and what the words mean. */
function differenceParts(comparison: Comparison, chosen: (id: string) => void): HTMLElement[] {
  const columns: Column<Difference>[] = [
    { head: tMeasure('what'), cell: (line) => h('button', { type: 'button', class: 'link', onclick: () => chosen(line.id) }, line.term) },
    { head: tMeasure('before_now'), number: true, cell: (line) => [h('span', null, shown(line, 'a')), h('br'), h('span', null, shown(line, 'b'))] },
    {
      head: tMeasure('difference'),
      number: true,
      cell: (line) => [differenceText(line), h('br'), h('span', { class: `badge ${line.significant ? 'warn' : ''}` }, tMeasure(line.significant === null ? 'untested' : line.significant ? 'significant' : 'not_significant'))],
    },
  ];
  const sorted = [...comparison.differences].sort((a, b) => Number(b.significant ?? false) - Number(a.significant ?? false));
  return [
    table(tMeasure('differences'), columns, sorted).root,
    h('p', { class: 'muted small' }, tMeasure('significance_note')),
    ...(comparison.not_comparable.length > 0 ? [h('details', { class: 'more' }, h('summary', null, tMeasure('not_comparable')), h('ul', null, ...comparison.not_comparable.map((line) => h('li', null, line))))] : []),
  ];
}

function differenceText(line: Difference): string {
  const difference = numberOf(line, 'difference');
  const sigma = numberOf(line, 'sigma');
  if (!difference) return '–';
  return changeText(difference.value, difference.unit) + (sigma ? ` ± ${valueText(sd95 * sigma.value, sigma.unit)}` : '');
}

function shown(line: Difference, name: 'a' | 'b'): string {
  const value = numberOf(line, name);
  return value ? valueText(value.value, value.unit) : '–';
}
