// The lines of a table of measurements, as the station writes them (docs/formats.md).
import type { Vec3 } from '../../view3d/mesh_pick';

export interface MeasurementsAnswer {
  measurements: Record<string, unknown>[];
  omitted?: unknown[];
}

export interface Line {
  id: string;
  term: string;
  definition: string;
  /** "mm", "mm2", "mm3" or "deg". */
  unit: string;
  value: number;
  /** Half width of the 95 % interval; null if it is not known. */
  half: number | null;
  /** Share of the path that the sensors saw. */
  seen: number | null;
  note: string;
  curve: Vec3[] | null;
  /** Shown on the body from the start. */
  main: boolean;
}

const mainLines = new Set(['neck_girth', 'chest_girth', 'waist_girth', 'hip_girth', 'head_girth']);

export function readMeasurements(answer: MeasurementsAnswer): Line[] {
  return answer.measurements.map(readLine).filter((line) => line !== null);
}

/** Null if it has no value: the unit is part of the key ("value_mm"). */
function readLine(json: Record<string, unknown>): Line | null {
  const key = Object.keys(json).find((name) => name.startsWith('value_'));
  const value = key ? json[key] : null;
  if (!key || typeof value !== 'number') return null;
  const unit = key.slice('value_'.length);
  const high = json[`high95_${unit}`];
  const text = (name: string) => (typeof json[name] === 'string' ? json[name] : '');
  const curve = json['curve'];
  return {
    id: text('id'),
    term: text('term') || text('id'),
    definition: text('definition'),
    unit,
    value,
    half: typeof high === 'number' ? high - value : null,
    seen: typeof json['measured_share'] === 'number' ? json['measured_share'] : null,
    note: text('note'),
    curve: Array.isArray(curve) && curve.length > 1 ? (curve as Vec3[]) : null,
    main: mainLines.has(text('id')),
  };
}
