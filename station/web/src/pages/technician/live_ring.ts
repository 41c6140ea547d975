// What the levels of a running ring say of each sensor: returns, scatter.
import { median } from '../../charts/scale';
import { sensorCount } from '../../charts/polar';

export interface LevelMessage {
  sweep: number;
  level: number;
  time_ns: number;
  sent_ms: number;
  z_mm: number;
  sensor_step: number;
  radius_mm: (number | null)[];
}

const kept = 240;
const judged = 16;

/**
 * Follows the last levels. The scatter of a sensor is estimated from second differences along the levels, so that the
 * body's slope does not count: sd = 1.4826 · median |r₋ − 2r + r₊| / √6. It needs five of them.
 */
export class LiveRing {
  /** Newest radius, mm; null: no return, undefined: not told. */
  readonly radius: (number | null | undefined)[] = Array<undefined>(sensorCount).fill(undefined);
  levels = 0;
  zMm = NaN;
  /** Between the station's sending and now, ms; not a number before the first. */
  delayMs = NaN;
  #history: (number | null)[][] = Array.from({ length: sensorCount }, () => []);

  take(level: LevelMessage, nowMs: number): void {
    this.levels += 1;
    this.zMm = level.z_mm;
    this.delayMs = nowMs - level.sent_ms;
    level.radius_mm.forEach((radius, k) => {
      const sensor = k * level.sensor_step;
      if (sensor >= sensorCount) return;
      this.radius[sensor] = radius;
      const history = this.#history[sensor]!;
      history.push(radius);
      if (history.length > kept) history.shift();
    });
  }

  /** Share of the last levels without a return; not a number before the first. */
  noReturnShare(sensor: number): number {
    const history = this.#history[sensor]!.slice(-judged);
    return history.length === 0 ? NaN : history.filter((one) => one === null).length / history.length;
  }

  /** sd of a reading, mm; not a number with too few. */
  scatter(sensor: number): number {
    const history = this.#history[sensor]!.slice(-judged);
    const differences: number[] = [];
    for (let k = 1; k + 1 < history.length; ++k) {
      const [before, here, after] = [history[k - 1]!, history[k]!, history[k + 1]!];
      if (before !== null && here !== null && after !== null) differences.push(Math.abs(before - 2 * here + after));
    }
    return differences.length < 5 ? NaN : (1.4826 * median(differences)) / Math.sqrt(6);
  }

  /** Of the last 240 levels, oldest first. */
  historyOf(sensor: number): readonly (number | null)[] {
    return this.#history[sensor]!;
  }
}
