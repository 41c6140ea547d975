// The ring seen from above, as a picture: station frame, the subject's front (theta 90 degrees) is up, the subject's right (theta 0) to
// the right. Lengths in mm, places in pixels.

export interface PolarFrame {
  /** Of the ring's axis, px. */
  centreX: number;
  centreY: number;
  /** px per mm. */
  scale: number;
}

export interface Point {
  x: number;
  y: number;
}

export const sensorCount = 180;
export const sensorStepDeg = 360 / sensorCount;
export const sensorsPerBoard = 15;

/** Fits a circle of `radius` mm and `margin` px around it into a picture. */
export function frameFor(width: number, height: number, radius: number, margin: number): PolarFrame {
  const room = Math.max(1, Math.min(width, height) / 2 - margin);
  return { centreX: width / 2, centreY: height / 2, scale: room / radius };
}

export function angleOfSensor(index: number): number {
  return (index * sensorStepDeg) % 360;
}

/** Where (theta, radius) is on the picture; y of a picture goes down. */
export function pointAt(frame: PolarFrame, thetaDeg: number, radius: number): Point {
  const theta = (thetaDeg * Math.PI) / 180;
  return { x: frame.centreX + frame.scale * radius * Math.cos(theta), y: frame.centreY - frame.scale * radius * Math.sin(theta) };
}

/** Theta (0 … 360) and radius (mm) of a place on the picture. */
export function polarOf(frame: PolarFrame, at: Point): { thetaDeg: number; radius: number } {
  const x = (at.x - frame.centreX) / frame.scale;
  const y = (frame.centreY - at.y) / frame.scale;
  return { thetaDeg: ((Math.atan2(y, x) * 180) / Math.PI + 360) % 360, radius: Math.hypot(x, y) };
}

/** The sensor whose beam is nearest to a place; null within `deadRadius` mm of the axis, where all beams meet. */
export function sensorAt(frame: PolarFrame, at: Point, deadRadius: number): number | null {
  const { thetaDeg, radius } = polarOf(frame, at);
  if (radius < deadRadius) return null;
  return Math.round(thetaDeg / sensorStepDeg) % sensorCount;
}

/** First sensor of every board and the angle of its boundary, half a step before it. */
export function boardBoundaries(perBoard = sensorsPerBoard): { board: number; first: number; thetaDeg: number }[] {
  return Array.from({ length: Math.ceil(sensorCount / perBoard) }, (_, board) => ({
    board,
    first: board * perBoard,
    thetaDeg: (((board * perBoard - 0.5) * sensorStepDeg) + 360) % 360,
  }));
}

/**
 * Runs of neighbouring returns around the ring, each a list of sensors; a run that goes over sensor 0 is one. Breaks
 * where a return is missing, or where the radius jumps by more than `jump` mm (another surface).
 */
export function contourRuns(radius: readonly (number | null)[], jump: number): number[][] {
  const count = radius.length;
  const joined = (from: number): boolean => {
    const [a, b] = [radius[from % count], radius[(from + 1) % count]];
    return typeof a === 'number' && typeof b === 'number' && Math.abs(a - b) <= jump;
  };
  const start = Array.from({ length: count }, (_, k) => k).find((k) => !joined(k + count - 1));
  if (start === undefined) return count > 0 ? [[...Array(count).keys(), 0]] : [];
  const runs: number[][] = [];
  let run: number[] = [];
  for (let k = start; k < start + count; ++k) {
    const sensor = k % count;
    if (typeof radius[sensor] !== 'number') continue;
    run.push(sensor);
    if (!joined(sensor)) {
      runs.push(run);
      run = [];
    }
  }
  if (run.length > 0) runs.push(run);
  return runs;
}
