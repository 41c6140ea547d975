// Where a calibration target is to stand: from above, and from the side that shows how it leans.
import { h, svg } from '../../core/dom';
import { pointAt } from '../../charts/polar';
import { t } from '../../words/technician';
import { placementText, type TargetPlace } from './target_place';

const size = 340;
const ringRadius = 600;

export interface FoundPlace {
  x_mm: number;
  y_mm: number;
  tilt_deg: number;
}

/** Front is up, as on the picture of the sensors. `found`: where it was seen to stand. */
export function targetPicture(place: TargetPlace, found: FoundPlace | null): HTMLElement {
  const label = placementText(place);
  return h(
    'figure',
    { class: 'target-picture' },
    h('div', { class: 'row', role: 'img', 'aria-label': label }, fromAbove(place, found), place.kind === 'plane' ? null : fromSide(place)),
    h('figcaption', null, h('strong', null, label), found ? h('span', { class: 'muted small' }, ` ${t('found_at', { x: found.x_mm.toFixed(0), y: found.y_mm.toFixed(0), tilt: found.tilt_deg.toFixed(1) })}`) : null),
  );
}

function fromAbove(place: TargetPlace, found: FoundPlace | null): SVGElement {
  // Only the middle of the ring: the target is small beside it.
  const shown = Math.max(260, Math.hypot(place.x_mm, place.y_mm) + (place.radius_mm || 150) + 60);
  const frame = { centreX: size / 2, centreY: size / 2, scale: (size / 2 - 28) / shown };
  const at = (x: number, y: number) => ({ x: frame.centreX + frame.scale * x, y: frame.centreY - frame.scale * y });
  const [middle, stands] = [at(0, 0), at(place.x_mm, place.y_mm)];
  const label = (thetaDeg: number, text: string) => {
    const p = pointAt(frame, thetaDeg, shown + 12 / frame.scale);
    return svg('text', { x: p.x, y: p.y, class: 'direction' }, text);
  };
  return svg(
    'svg',
    { viewBox: `0 0 ${size} ${size}`, class: 'from-above' },
    svg('circle', { cx: middle.x, cy: middle.y, r: Math.min(ringRadius, shown) * frame.scale, class: 'floor' }),
    svg('path', { d: `M${middle.x - shown * frame.scale} ${middle.y}H${middle.x + shown * frame.scale}M${middle.x} ${middle.y - shown * frame.scale}V${middle.y + shown * frame.scale}`, class: 'axes' }),
    label(90, t('front')),
    label(270, t('back')),
    shape(place, stands, frame.scale),
    lean(place, stands, frame.scale),
    dimension(middle, stands, place),
    found ? cross(at(found.x_mm, found.y_mm)) : null,
  );
}

/** A round target as a circle with its mark, a board as a line facing where it is turned to. */
function shape(place: TargetPlace, at: { x: number; y: number }, scale: number): SVGElement {
  const turn = ((place.turn_deg ?? 0) * Math.PI) / 180;
  if (place.kind === 'plane') {
    const half = 150 * scale;
    return svg('line', { x1: at.x - half * Math.cos(turn), y1: at.y + half * Math.sin(turn), x2: at.x + half * Math.cos(turn), y2: at.y - half * Math.sin(turn), class: 'board' });
  }
  const radius = Math.max(8, place.radius_mm * scale);
  const mark = place.turn_deg === null ? null : svg('line', { x1: at.x, y1: at.y, x2: at.x + radius * Math.cos(turn), y2: at.y - radius * Math.sin(turn), class: 'turn-mark' });
  return svg('g', null, svg('circle', { cx: at.x, cy: at.y, r: radius, class: place.verify ? 'target verify' : 'target' }), mark);
}

function lean(place: TargetPlace, at: { x: number; y: number }, scale: number): SVGElement | null {
  if (place.tilt_deg <= 0) return null;
  const theta = (place.tilt_to_deg * Math.PI) / 180;
  const [from, to] = [place.radius_mm * scale + 4, place.radius_mm * scale + 34];
  const end = { x: at.x + to * Math.cos(theta), y: at.y - to * Math.sin(theta) };
  const wing = (turn: number) => `L${end.x - 11 * Math.cos(theta + turn)} ${end.y + 11 * Math.sin(theta + turn)}`;
  return svg('path', { d: `M${at.x + from * Math.cos(theta)} ${at.y - from * Math.sin(theta)}L${end.x} ${end.y}${wing(0.5)}M${end.x} ${end.y}${wing(-0.5)}`, class: 'lean' });
}

/** From the middle along x, then along y, with the lengths. */
function dimension(middle: { x: number; y: number }, stands: { x: number; y: number }, place: TargetPlace): SVGElement | null {
  if (Math.hypot(place.x_mm, place.y_mm) < 1) return null;
  const corner = { x: stands.x, y: middle.y };
  const parts: (SVGElement | null)[] = [
    svg('path', { d: `M${middle.x} ${middle.y}H${corner.x}V${stands.y}`, class: 'dimension' }),
    Math.abs(place.x_mm) < 1 ? null : svg('text', { x: (middle.x + corner.x) / 2, y: middle.y + (place.y_mm > 0 ? 16 : -12), class: 'length' }, `${Math.abs(place.x_mm).toFixed(0)} mm`),
    Math.abs(place.y_mm) < 1 ? null : svg('text', { x: stands.x + (place.x_mm >= 0 ? 12 : -12), y: (middle.y + stands.y) / 2, class: place.x_mm >= 0 ? 'length from' : 'length to' }, `${Math.abs(place.y_mm).toFixed(0)} mm`),
    svg('circle', { cx: stands.x, cy: stands.y, r: 3, class: 'dot' }),
  ];
  return svg('g', null, parts);
}

function cross(at: { x: number; y: number }): SVGElement {
  return svg('path', { d: `M${at.x - 8} ${at.y - 8}l16 16M${at.x + 8} ${at.y - 8}l-16 16`, class: 'found' });
}

/** Seen across the lean: its top goes to the right. The lean is drawn three times as large as it is. */
function fromSide(place: TargetPlace): SVGElement {
  const foot = { x: place.tilt_deg > 0 ? size / 7 : size / 4, y: size - 46 };
  const height = 210;
  const half = Math.max(9, Math.min(36, place.radius_mm / 4));
  const angle = Math.min(40, place.tilt_deg * 3);
  const body =
    place.kind === 'sphere'
      ? [svg('line', { x1: foot.x, y1: foot.y, x2: foot.x, y2: foot.y - height + half, class: 'rod' }), svg('circle', { cx: foot.x, cy: foot.y - height, r: half, class: 'target' })]
      : [svg('rect', { x: foot.x - half, y: foot.y - height, width: 2 * half, height, class: place.verify ? 'target verify' : 'target' })];
  return svg(
    'svg',
    { viewBox: `0 0 ${size / 2} ${size}`, class: 'from-side' },
    svg('line', { x1: 8, x2: size / 2 - 8, y1: foot.y, y2: foot.y, class: 'floor-line' }),
    svg('line', { x1: foot.x, x2: foot.x, y1: foot.y, y2: foot.y - height - 26, class: 'plumb' }),
    svg('g', { transform: `rotate(${angle} ${foot.x} ${foot.y})` }, body),
    svg('text', { x: size / 4, y: foot.y + 26, class: 'direction' }, place.tilt_deg > 0 ? `${place.tilt_deg.toFixed(0)}° → ${place.tilt_to_deg.toFixed(0)}°` : t('upright')),
  );
}
