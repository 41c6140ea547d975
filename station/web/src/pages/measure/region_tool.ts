// Area and volume of the region between the planes ABC and ABD (paper 001, fig. 3.1).
import { h } from '../../core/dom';
import { button } from '../../core/ui';
import { tMeasure } from '../../words/measure';
import type { Vec3 } from '../../view3d/mesh_pick';
import { NewestOnly } from '../glasses/newest_only';
import type { Place, Region } from './api';
import { intervalText } from './numbers';
import { onSurfaceTap, SurfaceCursor } from './surface_cursor';
import { lineColours, Results, type Bench, type Tool } from './tool';

const names = ['a', 'b', 'c', 'd'] as const;

export function regionTool(bench: Bench): Tool {
  const { viewer, api } = bench;
  let cursors: SurfaceCursor[] = [];
  let end = (): void => {};
  const results = new Results();
  const feed = new NewestOnly(([a, b, c, d]: [Place, Place, Place, Place]) => api.region(a, b, c, d), (answer) => cursors.length === names.length && show(answer), (error) => {
    viewer.clear('region.line');
    results.fail(error);
  });
  const ask = (): void => {
    const points = cursors.flatMap((cursor) => (cursor.point ? [{ theta_deg: cursor.point.theta_deg, z_mm: cursor.point.z_mm }] : []));
    if (points.length === names.length) feed.ask(points as [Place, Place, Place, Place]);
    else results.hint(tMeasure('region_tap', { name: (names[cursors.length] ?? 'd').toUpperCase() }));
  };
  const add = (): SurfaceCursor => {
    const name = (names[cursors.length] ?? 'd').toUpperCase();
    const cursor = new SurfaceCursor(viewer, api, `region.${name}`, { letter: name, label: tMeasure('cursor', { name }) });
    cursor.moved = ask;
    cursor.failed = (error) => results.fail(error);
    cursors.push(cursor);
    return cursor;
  };
  const show = (answer: Region): void => {
    viewer.clear('region.line');
    outlines(answer.outline).forEach((line, i) => viewer.setLine(`region.line${i}`, line, { colour: lineColours.main, width_px: 4, through: true }));
    results.show([
      { term: tMeasure('region_area'), value: intervalText(answer.area_mm2, answer.area_sigma_mm2, 'mm2') },
      { term: tMeasure('volume'), value: intervalText(answer.volume_mm3, answer.volume_sigma_mm3, 'mm3') },
    ], tMeasure('region_note'));
  };
  const clear = (): void => {
    for (const cursor of cursors) cursor.remove();
    cursors = [];
    viewer.clear('region.');
    ask();
  };
  return {
    root: h('div', { class: 'stack' }, results.root, button(tMeasure('clear'), clear)),
    begin: () => {
      const kept = cursors.flatMap((cursor) => (cursor.point ? [cursor.point] : []));
      cursors = [];
      for (const point of kept) add().set(point);
      end = onSurfaceTap(viewer, (x, y) => {
        if (cursors.length < names.length && viewer.pick('body', x, y)) add().put(viewer.rayAt(x, y));
      });
      ask();
    },
    end: () => {
      end();
      for (const cursor of cursors) cursor.remove();
      viewer.clear('region.');
    },
  };
}

/** One line or several. */
function outlines(outline: Vec3[] | Vec3[][]): Vec3[][] {
  return typeof outline[0]?.[0] === 'number' ? [outline as Vec3[]] : (outline as Vec3[][]);
}
