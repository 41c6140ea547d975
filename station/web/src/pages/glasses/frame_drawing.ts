// A frame's front as a drawing (paper 000, figs. 8–15): rims on their octagons, bridge and temples' ends.
import { h, svg } from '../../core/dom';
import type { FieldValues } from './api';

interface Point {
  x: number;
  y: number;
}

function numberOf(values: FieldValues, option: string, otherwise: number): number {
  const value = values[option];
  return typeof value === 'number' ? value : otherwise;
}

/** Control points of the rim's centre line: four cubic Bezier curves M0 M1 M2 M3, M3 M4 M5 M6, … (paper 000, fig. 9). */
export function rimCentreLine(numbers: FieldValues): Point[] {
  const l1 = numberOf(numbers, 'width', 50);
  const l2 = numberOf(numbers, 'height', 40);
  const corner = (x: number, y: number, key: string): { x: number; y: number; t: number } => ({ x, y, t: numberOf(numbers, key, 8) });
  // P1 … P4 of the rim that is seen at the left; y upward from its lower edge.
  const corners = [corner(0, l2, 'upper-outer'), corner(l1, l2, 'upper-inner'), corner(l1, 0, 'lower-inner'), corner(0, 0, 'lower-outer')];
  const centre = { x: l1 / 2, y: l2 / 2 };
  const inward = (p: Point): Point => ({ x: Math.sign(centre.x - p.x), y: Math.sign(centre.y - p.y) });
  const along = (from: (typeof corners)[number], to: (typeof corners)[number]): Point => {
    // The cut at a corner, at distance t from it and under 45°, meets the sides at t·√2 from the corner.
    const length = Math.hypot(to.x - from.x, to.y - from.y);
    const share = (from.t * Math.SQRT2) / length;
    return { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y) };
  };
  return corners.flatMap((from, i) => {
    const to = corners[(i + 1) % 4]!;
    const middle = { x: from.x + (inward(from).x * from.t) / Math.SQRT2, y: from.y + (inward(from).y * from.t) / Math.SQRT2 };
    return [middle, along(from, to), along(to, from)];
  });
}

export interface DrawingColours {
  upper: string;
  lower: string;
  lens: string;
}

/** The front as the viewer sees it, mirrored about the bridge. `label` is read out. */
export function frameDrawing(numbers: FieldValues, colours: DrawingColours, label: string): SVGElement {
  const l1 = numberOf(numbers, 'width', 50);
  const l2 = numberOf(numbers, 'height', 40);
  const gap = numberOf(numbers, 'bridge-gap', l1 / 5);
  const bridge = numberOf(numbers, 'bridge-height', 0.6 * l2);
  const upper = numberOf(numbers, 'upper-thickness', 2.5);
  const lower = numberOf(numbers, 'lower-thickness', 2.5);
  const points = rimCentreLine(numbers).map((p) => ({ x: p.x - l1 - gap / 2, y: -p.y }));
  const text = (p: Point): string => `${p.x.toFixed(2)} ${p.y.toFixed(2)}`;
  const at = (i: number): string => text(points[i % points.length]!);
  const curve = (first: number): string => `C ${at(first + 1)}, ${at(first + 2)}, ${at(first + 3)}`;
  const all = `M ${at(0)} ${[0, 3, 6, 9].map(curve).join(' ')} Z`;
  const half = (side: 1 | -1): SVGElement =>
    svg('g', { transform: side === 1 ? null : 'scale(-1 1)' },
      svg('path', { d: all, fill: colours.lens, 'fill-opacity': 0.35 }),
      svg('path', { d: `M ${at(6)} ${curve(6)}`, fill: 'none', stroke: colours.lower, 'stroke-width': lower }),
      svg('path', { d: `M ${at(3)} ${curve(3)}`, fill: 'none', stroke: colours.upper, 'stroke-width': (upper + lower) / 2 }),
      svg('path', { d: `M ${at(9)} ${curve(9)}`, fill: 'none', stroke: colours.upper, 'stroke-width': (upper + lower) / 2 }),
      svg('path', { d: `M ${at(0)} ${curve(0)}`, fill: 'none', stroke: colours.upper, 'stroke-width': upper, 'stroke-linecap': 'round' }),
      svg('line', { x1: -l1 - gap / 2, y1: -bridge, x2: -l1 - gap / 2 - 4, y2: -bridge, stroke: colours.upper, 'stroke-width': upper }),
    );
  const width = 2 * l1 + gap + 12;
  return svg(
    'svg',
    { class: 'frame-drawing', viewBox: `${-width / 2} ${-l2 - 4} ${width} ${l2 + 8}`, role: 'img', 'aria-label': label },
    svg('line', { x1: -gap / 2, y1: -bridge, x2: gap / 2, y2: -bridge, stroke: colours.upper, 'stroke-width': upper }),
    half(1),
    half(-1),
  );
}

/** The drawing with room kept while there is none. */
export function drawingBox(): HTMLElement {
  return h('div', { class: 'drawing-box' });
}
