// The ring from above, with what it sees now, as SVG.
import { h, replace, svg } from '../core/dom';
import { tCharts } from './words';
import { boardBoundaries, contourRuns, frameFor, pointAt, type PolarFrame, sensorAt, sensorCount, sensorsPerBoard, sensorStepDeg } from './polar';
import './charts.css';

export interface RingCell {
  /** Colour of the sensor's cell on the rim, or null: nothing known. */
  colour: string | null;
  /** Marked with a triangle besides the colour. */
  marked: boolean;
}

export interface RingView {
  root: HTMLElement;
  /** Radii of the newest level (mm; null: no return, undefined: not told). */
  setRadii(radii: readonly (number | null | undefined)[]): void;
  setCells(cells: readonly RingCell[]): void;
  setPicked(sensor: number | null): void;
}

export interface RingLook {
  ringRadius: number;
  /** Told of the sensor that was picked. */
  pick(sensor: number): void;
}

const size = 640;
const rim = { inner: 6, outer: 26 };
const jumpMm = 60;

export function ringView(look: RingLook): RingView {
  const frame = frameFor(size, size, look.ringRadius, 70);
  const radii: (number | null | undefined)[] = Array<undefined>(sensorCount).fill(undefined);
  let picked: number | null = null;
  const cells = Array.from({ length: sensorCount }, (_, sensor) => cell(frame, look.ringRadius, sensor));
  const marks = svg('g', { class: 'ring-marks' });
  const body = svg('path', { class: 'ring-body' });
  const dots = svg('path', { class: 'ring-dots' });
  const misses = svg('path', { class: 'ring-misses' });
  const beam = svg('g', { class: 'ring-beam' });
  const picture = svg('svg', { viewBox: `0 0 ${size} ${size}`, class: 'ring-picture', 'aria-hidden': 'true' }, scaffold(frame, look.ringRadius), svg('g', null, cells), marks, misses, body, dots, beam);
  const root = h('div', { class: 'ring-view', role: 'img', tabindex: 0, 'aria-label': tCharts('ring_label') }, picture);

  const drawBeam = () => replace(beam, ...beamOf(frame, look.ringRadius, picked, radii));
  root.onpointerdown = (event) => {
    const box = picture.getBoundingClientRect();
    const scale = size / box.width;
    const sensor = sensorAt(frame, { x: (event.clientX - box.left) * scale, y: (event.clientY - box.top) * scale }, 20);
    if (sensor !== null) look.pick(sensor);
  };
  root.onkeydown = (event) => {
    // Sensors are counted counter-clockwise seen from above.
    const step = { ArrowRight: -1, ArrowLeft: 1, PageUp: sensorsPerBoard, PageDown: -sensorsPerBoard }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    look.pick(((picked ?? 45) + step + sensorCount) % sensorCount);
  };
  return {
    root,
    setRadii(now) {
      now.forEach((radius, sensor) => (radii[sensor] = radius));
      const told = now.map((radius, sensor) => ({ radius, sensor })).filter((one): one is { radius: number | null; sensor: number } => one.radius !== undefined);
      body.setAttribute('d', outline(frame, told));
      dots.setAttribute('d', told.map(({ radius, sensor }) => (radius === null ? '' : dot(frame, sensor, radius))).join(''));
      misses.setAttribute('d', told.map(({ radius, sensor }) => (radius === null ? miss(frame, look.ringRadius, sensor) : '')).join(''));
      drawBeam();
    },
    setCells(all) {
      all.forEach((one, sensor) => cells[sensor]?.setAttribute('fill', one.colour ?? 'var(--raised)'));
      replace(marks, ...all.flatMap((one, sensor) => (one.marked ? [mark(frame, look.ringRadius, sensor)] : [])));
    },
    setPicked(sensor) {
      picked = sensor;
      cells.forEach((one, k) => one.classList.toggle('picked', k === sensor));
      drawBeam();
    },
  };
}

function outer(frame: PolarFrame, ringRadius: number, px: number): number {
  return ringRadius + px / frame.scale;
}

function text(frame: PolarFrame, thetaDeg: number, radius: number, content: string, kind: string): SVGElement {
  const at = pointAt(frame, thetaDeg, radius);
  return svg('text', { x: at.x.toFixed(1), y: at.y.toFixed(1), class: kind }, content);
}

/** Circles every 100 mm, axes, board boundaries with their numbers, directions. */
function scaffold(frame: PolarFrame, ringRadius: number): SVGElement {
  const circles: SVGElement[] = [];
  for (let radius = 100; radius < ringRadius; radius += 100) {
    circles.push(svg('circle', { cx: frame.centreX, cy: frame.centreY, r: (radius * frame.scale).toFixed(1), class: 'ring-grid' }));
  }
  const scale = [200, 400].filter((radius) => radius < ringRadius).map((radius) => text(frame, 40, radius, `${radius}`, 'ring-scale'));
  const line = (thetaDeg: number, from: number, to: number, kind: string) => {
    const [a, b] = [pointAt(frame, thetaDeg, from), pointAt(frame, thetaDeg, to)];
    return svg('line', { x1: a.x.toFixed(1), y1: a.y.toFixed(1), x2: b.x.toFixed(1), y2: b.y.toFixed(1), class: kind });
  };
  const axes = [0, 90, 180, 270].map((theta) => line(theta, 0, ringRadius, 'ring-grid'));
  const boards = boardBoundaries().flatMap(({ board, thetaDeg }) => [
    line(thetaDeg, ringRadius, outer(frame, ringRadius, rim.outer + 10), 'ring-board'),
    text(frame, thetaDeg + (sensorsPerBoard * sensorStepDeg) / 2, outer(frame, ringRadius, rim.outer + 15), tCharts('board', { n: board + 1 }), 'ring-board-name'),
  ]);
  const directions = (['right', 'front', 'left', 'back'] as const).map((key, k) => text(frame, 90 * k, ringRadius * 0.88, tCharts(key), 'ring-direction'));
  const ring = svg('circle', { cx: frame.centreX, cy: frame.centreY, r: (ringRadius * frame.scale).toFixed(1), class: 'ring-circle' });
  return svg('g', null, circles, axes, ring, boards, scale, directions);
}

function corner(frame: PolarFrame, thetaDeg: number, radius: number): string {
  const at = pointAt(frame, thetaDeg, radius);
  return `${at.x.toFixed(1)} ${at.y.toFixed(1)}`;
}

function cell(frame: PolarFrame, ringRadius: number, sensor: number): SVGElement {
  const [from, to] = [(sensor - 0.46) * sensorStepDeg, (sensor + 0.46) * sensorStepDeg];
  const [inner, far] = [outer(frame, ringRadius, rim.inner), outer(frame, ringRadius, rim.outer)];
  const d = `M${corner(frame, from, inner)}L${corner(frame, from, far)}L${corner(frame, to, far)}L${corner(frame, to, inner)}Z`;
  return svg('path', { d, class: 'ring-cell', fill: 'var(--raised)' });
}

/** A triangle outside the rim, pointing at the sensor. */
function mark(frame: PolarFrame, ringRadius: number, sensor: number): SVGElement {
  const theta = sensor * sensorStepDeg;
  const [tip, base] = [outer(frame, ringRadius, rim.outer + 2), outer(frame, ringRadius, rim.outer + 16)];
  return svg('path', { d: `M${corner(frame, theta, tip)}L${corner(frame, theta - 1.8, base)}L${corner(frame, theta + 1.8, base)}Z`, class: 'ring-mark' });
}

function outline(frame: PolarFrame, told: { radius: number | null; sensor: number }[]): string {
  const runs = contourRuns(told.map((one) => one.radius), jumpMm);
  return runs.map((run) => run.map((k, n) => `${n === 0 ? 'M' : 'L'}${corner(frame, told[k]!.sensor * sensorStepDeg, told[k]!.radius!)}`).join('')).join('');
}

function dot(frame: PolarFrame, sensor: number, radius: number): string {
  return `M${corner(frame, sensor * sensorStepDeg, radius)}h0`;
}

function miss(frame: PolarFrame, ringRadius: number, sensor: number): string {
  const theta = sensor * sensorStepDeg;
  return `M${corner(frame, theta, ringRadius - 4 / frame.scale)}L${corner(frame, theta, ringRadius - 22 / frame.scale)}`;
}

function beamOf(frame: PolarFrame, ringRadius: number, sensor: number | null, radii: readonly (number | null | undefined)[]): SVGElement[] {
  if (sensor === null) return [];
  const theta = sensor * sensorStepDeg;
  const radius = radii[sensor];
  const path = svg('path', { d: `M${corner(frame, theta, ringRadius)}L${corner(frame, theta, radius ?? 0)}`, class: typeof radius === 'number' ? 'hit' : 'open' });
  const name = text(frame, theta, outer(frame, ringRadius, rim.outer + 36), String(sensor), 'ring-picked');
  if (typeof radius !== 'number') return [path, name];
  const at = pointAt(frame, theta, radius);
  return [path, svg('circle', { cx: at.x.toFixed(1), cy: at.y.toFixed(1), r: 6, class: 'hit' }), name];
}
