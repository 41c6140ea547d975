// The axis as a picture: travel with its ends, the carriage, heights.
import { h, replace, svg } from '../../core/dom';
import { placed, ticks } from '../../charts/scale';
import { t } from '../../words/technician';

export interface AxisView {
  zMin: number | null;
  zMax: number | null;
  z: number | null;
  homed: boolean;
  /** +1 up, −1 down, 0 at rest. */
  moving: number;
}

const height = 460;
const width = 330;
const rail = { x: 120, top: 28, bottom: height - 28 };

export function axisPicture() {
  const root = h('div', { class: 'axis-picture', role: 'img' });
  return {
    root,
    set(view: AxisView): void {
      root.setAttribute('aria-label', spoken(view));
      replace(root, drawn(view));
    },
  };
}

function spoken(view: AxisView): string {
  if (!view.homed || view.z === null) return t('axis_not_homed');
  return t('axis_at', { z: view.z.toFixed(1), low: view.zMin ?? '–', high: view.zMax ?? '–' });
}

function drawn(view: AxisView): SVGElement {
  const [low, high] = [view.zMin ?? 0, view.zMax ?? 2000];
  const y = (z: number) => placed(z, { low, high }, { low: rail.bottom, high: rail.top });
  const scale = ticks(low, high, 8).flatMap((z) => [
    svg('line', { x1: rail.x - 12, x2: rail.x, y1: y(z), y2: y(z), class: 'rail' }),
    svg('text', { x: rail.x - 18, y: y(z), class: 'end' }, String(z)),
  ]);
  const limit = (z: number, text: string) => [
    svg('line', { x1: rail.x - 16, x2: rail.x + 160, y1: y(z), y2: y(z), class: 'limit' }),
    svg('text', { x: rail.x + 160, y: y(z) + (z === high ? -12 : 14), class: 'limit-text' }, `${text} ${z.toFixed(0)} mm`),
  ];
  return svg(
    'svg',
    { viewBox: `0 0 ${width} ${height}` },
    svg('line', { x1: rail.x, x2: rail.x, y1: rail.top, y2: rail.bottom, class: 'rail' }),
    scale,
    limit(high, t('limit_high')),
    limit(low, t('limit_low')),
    view.homed && view.z !== null ? carriage(y(view.z), view.z, view.moving) : svg('text', { x: rail.x + 90, y: height / 2, class: 'unknown' }, t('not_homed_short')),
  );
}

/** The ring from the side, with its height beside it, and an arrow while it moves. */
function carriage(y: number, z: number, moving: number): SVGElement {
  const arrow = moving === 0 ? null : svg('path', { d: moving > 0 ? `M${rail.x + 90} ${y - 34}l12 18h-24z` : `M${rail.x + 90} ${y + 34}l12 -18h-24z`, class: 'arrow' });
  return svg(
    'g',
    null,
    svg('rect', { x: rail.x - 7, y: y - 11, width: 14, height: 22, class: 'carriage' }),
    svg('rect', { x: rail.x + 8, y: y - 6, width: 84, height: 12, rx: 6, class: 'carriage' }),
    arrow,
    // Beside the carriage, but clear of the ends' own words.
    svg('text', { x: rail.x + 100, y: Math.min(rail.bottom - 22, Math.max(rail.top + 22, y)), class: 'z' }, `${z.toFixed(1)} mm`),
  );
}
