// From numbers to places on a picture, and back.

export interface Range {
  low: number;
  high: number;
}

/** Places `value` of `from` into `to`; not clipped. */
export function placed(value: number, from: Range, to: Range): number {
  return to.low + ((value - from.low) / (from.high - from.low)) * (to.high - to.low);
}

/** Round numbers from low to high, about `wanted` of them: steps of 1, 2 or 5 times a power of ten. */
export function ticks(low: number, high: number, wanted: number): number[] {
  if (!(high > low) || wanted < 1) return [low];
  const rough = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((times) => times * power).find((one) => one >= rough * 0.999)!;
  const result: number[] = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + step * 1e-9; ++n) result.push(Number((n * step).toPrecision(12)));
  return result;
}

/**
 * The ends of a colour scale: the middle `share` of the values, so that a few wild ones do not wash out the rest; not a
 * number is left out. `symmetric` puts zero into the middle. `least` is the smallest width.
 */
export function robustRange(values: ArrayLike<number>, share: number, options: { symmetric?: boolean; least?: number } = {}): Range {
  const finite = Array.from(values as ArrayLike<number>).filter(Number.isFinite);
  const least = options.least ?? 1e-9;
  if (finite.length === 0) return options.symmetric ? { low: -least / 2, high: least / 2 } : { low: 0, high: least };
  if (options.symmetric) {
    const size = Float64Array.from(finite, Math.abs).sort();
    const end = Math.max(quantile(size, share), least / 2);
    return { low: -end, high: end };
  }
  const sorted = Float64Array.from(finite).sort();
  const low = quantile(sorted, (1 - share) / 2);
  const high = quantile(sorted, (1 + share) / 2);
  const missing = Math.max(0, least - (high - low)) / 2;
  return { low: low - missing, high: high + missing };
}

/** Of sorted numbers, linear between them. */
export function quantile(sorted: ArrayLike<number>, share: number): number {
  const place = share * (sorted.length - 1);
  const below = Math.floor(place);
  const above = Math.min(sorted.length - 1, below + 1);
  return sorted[below]! + (place - below) * (sorted[above]! - sorted[below]!);
}

/** Median of what is finite; not a number if nothing is. */
export function median(values: ArrayLike<number>): number {
  const sorted = Float64Array.from(Array.from(values as ArrayLike<number>).filter(Number.isFinite)).sort();
  return sorted.length === 0 ? NaN : quantile(sorted, 0.5);
}

/** A window zoomed by `factor` (below 1: nearer) about a place that stays where it is, within the whole; never narrower than `least`. */
export function zoomed(window: Range, whole: Range, about: number, factor: number, least: number): Range {
  const full = whole.high - whole.low;
  const width = Math.min(full, Math.max(Math.min(least, full), (window.high - window.low) * factor));
  const share = window.high > window.low ? (about - window.low) / (window.high - window.low) : 0.5;
  const low = Math.min(Math.max(whole.low, about - share * width), whole.high - width);
  return { low, high: low + width };
}

/** A window moved by `by`, as far as the whole goes. */
export function moved(window: Range, whole: Range, by: number): Range {
  const shift = Math.min(Math.max(by, whole.low - window.low), whole.high - window.high);
  return { low: window.low + shift, high: window.high + shift };
}
