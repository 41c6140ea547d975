// Time along a line of pixels, and playing along it. Times in seconds from the recording's beginning.

export interface TimeWindow {
  fromS: number;
  toS: number;
}

export function xOf(window: TimeWindow, timeS: number, width: number): number {
  return ((timeS - window.fromS) / (window.toS - window.fromS)) * width;
}

export function timeAt(window: TimeWindow, x: number, width: number): number {
  return window.fromS + (x / width) * (window.toS - window.fromS);
}

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

/** Window zoomed by `factor` about a time, within the whole; never narrower than `least` seconds. */
export function zoomedTime(window: TimeWindow, whole: TimeWindow, aboutS: number, factor: number, least = 0.05): TimeWindow {
  const full = whole.toS - whole.fromS;
  const width = Math.min(full, Math.max(Math.min(least, full), (window.toS - window.fromS) * factor));
  const share = (aboutS - window.fromS) / (window.toS - window.fromS);
  const from = Math.min(Math.max(whole.fromS, aboutS - share * width), whole.toS - width);
  return { fromS: from, toS: from + width };
}

/** Events at pixels closer than `least` become one mark with their count, so that nothing is drawn over another. */
export function clustered<T extends { timeS: number }>(events: readonly T[], window: TimeWindow, width: number, least: number): { x: number; events: T[] }[] {
  const result: { x: number; events: T[] }[] = [];
  for (const event of [...events].sort((a, b) => a.timeS - b.timeS)) {
    const x = xOf(window, event.timeS, width);
    if (x < 0 || x > width) continue;
    const last = result.at(-1);
    if (last && x - last.x < least) last.events.push(event);
    else result.push({ x, events: [event] });
  }
  return result;
}

/** Stretches during which a line was high: changes in time order, until the end. */
export function highStretches(changes: readonly { timeS: number; level: boolean }[], endS: number): TimeWindow[] {
  const result: TimeWindow[] = [];
  let since: number | null = null;
  for (const change of changes) {
    if (change.level && since === null) since = change.timeS;
    if (!change.level && since !== null) {
      result.push({ fromS: since, toS: change.timeS });
      since = null;
    }
  }
  if (since !== null) result.push({ fromS: since, toS: endS });
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

  constructor(private readonly whole: TimeWindow) {
    this.#atS = whole.fromS;
  }

  get speed(): number {
    return this.#speed;
  }

  playing(nowMs: number): boolean {
    return this.#since !== null && this.time(nowMs) < this.whole.toS;
  }

  time(nowMs: number): number {
    if (this.#since === null) return this.#atS;
    return Math.min(this.whole.toS, this.#atS + ((nowMs - this.#since) / 1000) * this.#speed);
  }

  play(nowMs: number): void {
    if (this.playing(nowMs)) return;
    this.#atS = this.time(nowMs) >= this.whole.toS ? this.whole.fromS : this.time(nowMs);
    this.#since = nowMs;
  }

  pause(nowMs: number): void {
    this.#atS = this.time(nowMs);
    this.#since = null;
  }

  seek(timeS: number, nowMs: number): void {
    this.#atS = Math.min(this.whole.toS, Math.max(this.whole.fromS, timeS));
    if (this.#since !== null) this.#since = nowMs;
  }

  setSpeed(speed: number, nowMs: number): void {
    this.#atS = this.time(nowMs);
    if (this.#since !== null) this.#since = nowMs;
    this.#speed = speed;
  }
}
