// Length over the body from A to B: along a plane through C, along a plane of sight, the shortest way, or a taut tape.
import { h } from '../../core/dom';
import { button } from '../../core/ui';
import { tMeasure } from '../../words/measure';
import { segmented } from '../glasses/controls';
import { NewestOnly } from '../glasses/newest_only';
import type { Distance, DistanceQuestion, Method } from './api';
import { intervalText, valueText } from './numbers';
import { onSurfaceTap, SurfaceCursor } from './surface_cursor';
import { lineColours, Results, type Bench, type Tool } from './tool';

const methods: readonly Method[] = ['tape', 'geodesic', 'plane', 'view'];
type Name = 'a' | 'b' | 'c';

export function distanceTool(bench: Bench): Tool {
  const { viewer, api } = bench;
  let method: Method = 'tape';
  let cursors = new Map<Name, SurfaceCursor>();
  let ends: (() => void)[] = [];
  const results = new Results();
  const feed = new NewestOnly((question: DistanceQuestion) => api.distance(question), (answer, question) => show(answer, question), (error) => results.fail(error));
  const choose = segmented<Method>(tMeasure('method'), methods.map((one) => [one, tMeasure(one)] as const), (value) => {
    method = value;
    if (method !== 'plane') removeCursor('c');
    viewer.clear('distance.line');
    ask();
  });
  choose.set(method);

  const wanted = (): Name[] => (method === 'plane' ? ['a', 'b', 'c'] : ['a', 'b']);
  const ask = (): void => {
    const [from, to, via] = (['a', 'b', 'c'] as const).map((name) => cursors.get(name)?.point);
    const missing = wanted().find((name) => !cursors.get(name)?.point);
    if (!from || !to || (method === 'plane' && !via)) return results.hint(tMeasure('tap_for', { name: (missing ?? 'a').toUpperCase() }));
    const { azimuth_deg, elevation_deg } = viewer.camera();
    feed.ask({
      from: { theta_deg: from.theta_deg, z_mm: from.z_mm },
      to: { theta_deg: to.theta_deg, z_mm: to.z_mm },
      method,
      ...(method === 'plane' && via && { via: { theta_deg: via.theta_deg, z_mm: via.z_mm } }),
      ...(method === 'view' && { view: { azimuth_deg, elevation_deg } }),
    });
  };
  const removeCursor = (name: Name): void => {
    cursors.get(name)?.remove();
    cursors.delete(name);
  };
  const addCursor = (name: Name): SurfaceCursor => {
    const cursor = new SurfaceCursor(viewer, api, `distance.${name}`, { letter: name.toUpperCase(), label: tMeasure('cursor', { name: name.toUpperCase() }) });
    cursor.moved = ask;
    cursor.failed = (error) => results.fail(error);
    cursors.set(name, cursor);
    return cursor;
  };
  const show = (answer: Distance, question: DistanceQuestion): void => {
    if (question.method !== method || cursors.size === 0) return;
    viewer.setLine('distance.line', answer.path, { colour: lineColours.main, width_px: 4, through: true });
    const middle = answer.path[Math.floor(answer.path.length / 2)];
    if (middle) viewer.setLabel('distance.label', middle, intervalText(answer.length_mm, answer.sigma_mm, 'mm'));
    const straight = straightLine(cursors);
    results.show([
      { term: tMeasure(method), value: intervalText(answer.length_mm, answer.sigma_mm, 'mm'), note: tMeasure('measured', { share: Math.round(100 * answer.measured_share) }) },
      ...(straight === null ? [] : [{ term: tMeasure('straight'), value: valueText(straight, 'mm') }]),
    ], tMeasure(`${method}_note`));
  };
  const clear = (): void => {
    for (const name of [...cursors.keys()]) removeCursor(name);
    viewer.clear('distance.');
    ask();
  };
  return {
    root: h('div', { class: 'stack' }, choose.root, results.root, button(tMeasure('clear'), clear)),
    begin: () => {
      ends = [
        onSurfaceTap(viewer, (x, y) => {
          const name = wanted().find((one) => !cursors.has(one));
          if (name && viewer.pick('body', x, y)) addCursor(name).put(viewer.rayAt(x, y));
        }),
        viewer.onCamera(() => method === 'view' && ask()),
      ];
      const kept = cursors;
      cursors = new Map();
      for (const [name, old] of kept) if (old.point) addCursor(name).set(old.point);
      ask();
    },
    end: () => {
      for (const end of ends) end();
      for (const cursor of cursors.values()) cursor.remove();
      viewer.clear('distance.');
    },
  };
}

/** From A to B through the air; null until both are there. */
function straightLine(cursors: Map<Name, SurfaceCursor>): number | null {
  const [a, b] = [cursors.get('a')?.point?.position, cursors.get('b')?.point?.position];
  return a && b ? Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) : null;
}
