// Times along a line, and playing along it. Times in seconds from the recording's beginning.
import { placed, type Range } from './scale';

/** The last level that was there at a time (0 before the first); `timesS` rises. */
export function levelAt(timesS: ArrayLike<number>, timeS: number): number {
  let low = 0;
  let high = timesS.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (timesS[middle]! <= timeS) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}

/** The level whose time is nearest. */
export function nearestLevel(timesS: ArrayLike<number>, timeS: number): number {
  const below = levelAt(timesS, timeS);
  if (below + 1 >= timesS.length) return below;
  return timeS - timesS[below]! <= timesS[below + 1]! - timeS ? below : below + 1;
}

/** Events at pixels closer than `least` become one mark with their count, so that nothing is drawn over another. */
export function clustered<T extends { timeS: number }>(events: readonly T[], window: Range, width: number, least: number): { x: number; events: T[] }[] {
  const result: { x: number; events: T[] }[] = [];
  for (const event of [...events].sort((a, b) => a.timeS - b.timeS)) {
    const x = placed(event.timeS, window, { low: 0, high: width });
    if (x < 0 || x > width) continue;
    const last = result.at(-1);
    if (last && x - last.x < least) last.events.push(event);
    else result.push({ x, events: [event] });
  }
  return result;
}

/** Stretches during which a line was high: changes in time order, until the end. */
export function highStretches(changes: readonly { timeS: number; level: boolean }[], endS: number): Range[] {
  const result: Range[] = [];
  let since: number | null = null;
  for (const change of changes) {
    if (change.level && since === null) since = change.timeS;
    if (!change.level && since !== null) {
      result.push({ low: since, high: change.timeS });
      since = null;
    }
  }
  if (since !== null) result.push({ low: since, high: endS });
  return result;
}

/**
 * Where playing is: a place that moves with the clock times a speed. The clock (ms) is given from outside at every call.
 * It stops at the end; playing from the end begins anew.
 */
export class Player {
  #atS: number;
  #speed = 1;
  #since: number | null = null;

  constructor(private readonly whole: Range) {
    this.#atS = whole.low;
  }

  get speed(): number {
    return this.#speed;
  }

  playing(nowMs: number): boolean {
    return this.#since !== null && this.time(nowMs) < this.whole.high;
  }

  time(nowMs: number): number {
    if (this.#since === null) return this.#atS;
    return Math.min(this.whole.high, this.#atS + ((nowMs - this.#since) / 1000) * this.#speed);
  }

  play(nowMs: number): void {
    if (this.playing(nowMs)) return;
    this.#atS = this.time(nowMs) >= this.whole.high ? this.whole.low : this.time(nowMs);
    this.#since = nowMs;
  }

  pause(nowMs: number): void {
    this.#atS = this.time(nowMs);
    this.#since = null;
  }

  seek(timeS: number, nowMs: number): void {
    this.#atS = Math.min(this.whole.high, Math.max(this.whole.low, timeS));
    if (this.#since !== null) this.#since = nowMs;
  }

  setSpeed(speed: number, nowMs: number): void {
    this.#atS = this.time(nowMs);
    if (this.#since !== null) this.#since = nowMs;
    this.#speed = speed;
  }
}
