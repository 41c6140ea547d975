// The points of all sensors as one matrix: scans (rows, in time order) × sensors.
import { sensorCount } from '../../charts/polar';

export interface DriftSensor {
  index: number;
  points: [timeMs: number, offsetMm: number | null, sigmaMm: number | null][];
}

export function driftMatrix(sensors: readonly DriftSensor[]): { times: number[]; matrix: { rows: number; columns: number; values: Float32Array } } {
  const times = [...new Set(sensors.flatMap((sensor) => sensor.points.map(([time]) => time)))].sort((a, b) => a - b);
  const rowOf = new Map(times.map((time, row) => [time, row]));
  const values = new Float32Array(times.length * sensorCount).fill(NaN);
  for (const { index, points } of sensors) {
    for (const [time, offset] of points) {
      if (offset !== null && index < sensorCount) values[rowOf.get(time)! * sensorCount + index] = offset;
    }
  }
  return { times, matrix: { rows: times.length, columns: sensorCount, values } };
}
