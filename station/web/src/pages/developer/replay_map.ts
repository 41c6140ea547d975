// The ranges of all levels of a recording, as the station sends them (docs/console_api.md §12).
import { type Matrix, transposed } from '../../charts/heat_map';

export interface ReplayMap {
  levels: number;
  sensors: number;
  /** Levels × sensors, mm; not a number: no return. */
  range: Float32Array;
  zMm: Float32Array;
  /** Since the recording's beginning. */
  timesS: Float64Array;
}

/** @throws Error if the bytes are not as long as their head says. */
export function readReplayMap(bytes: ArrayBuffer): ReplayMap {
  const view = new DataView(bytes);
  if (bytes.byteLength < 8) throw new Error('the map of the recording is cut short');
  const levels = view.getUint32(0, true);
  const sensors = view.getUint32(4, true);
  const [ranges, heights] = [8 + 4 * levels * sensors, 8 + 4 * levels * sensors + 4 * levels];
  if (bytes.byteLength !== heights + 8 * levels) throw new Error(`the map of the recording has ${bytes.byteLength} bytes instead of ${heights + 8 * levels}`);
  return {
    levels,
    sensors,
    range: new Float32Array(bytes.slice(8, ranges)),
    zMm: new Float32Array(bytes.slice(ranges, heights)),
    timesS: new Float64Array(bytes.slice(heights)),
  };
}

/** Sensors × levels: time goes to the right. */
export function sensorsDown(map: ReplayMap): Matrix {
  return transposed({ rows: map.levels, columns: map.sensors, values: map.range });
}

/** Ranges of one level; null: no return. */
export function rangesOf(map: ReplayMap, level: number): (number | null)[] {
  const row = map.range.subarray(level * map.sensors, (level + 1) * map.sensors);
  return Array.from(row, (one) => (Number.isFinite(one) ? one : null));
}

/** How long a level is shown on the map before a gap begins: one and a half of the usual step. */
export function holdOf(timesS: ArrayLike<number>): number {
  const steps = Array.from({ length: Math.max(0, timesS.length - 1) }, (_, k) => timesS[k + 1]! - timesS[k]!).sort((a, b) => a - b);
  return steps.length === 0 ? 1 : 1.5 * steps[Math.floor(steps.length / 2)]!;
}
