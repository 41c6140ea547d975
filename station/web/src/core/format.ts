// Numbers and dates as people read them.
import { language } from './words';

export type Units = 'mm' | 'cm' | 'inch';

const locale = () => (language.value === 'ja' ? 'ja-JP' : 'en-GB');

export function dateTime(ms: number | null): string {
  if (!ms) return '—';
  return new Intl.DateTimeFormat(locale(), { dateStyle: 'medium', timeStyle: 'short' }).format(ms);
}

export function date(ms: number | null): string {
  if (!ms) return '—';
  return new Intl.DateTimeFormat(locale(), { dateStyle: 'medium' }).format(ms);
}

export function fixed(value: number, digits: number): string {
  return new Intl.NumberFormat(locale(), { minimumFractionDigits: digits, maximumFractionDigits: digits }).format(value);
}

export function bytes(count: number): string {
  const names = ['B', 'kB', 'MB', 'GB', 'TB'];
  let value = count;
  let k = 0;
  while (value >= 1000 && k < names.length - 1) {
    value /= 1000;
    k += 1;
  }
  return `${fixed(value, k === 0 || value >= 100 ? 0 : 1)} ${names[k]}`;
}

const kMmPerInch = 25.4;

/**
 * A measured quantity in the person's units, with no more digits than its 95 % half width allows. `unit` is the
 * station's: "mm", "mm2", "mm3" or "deg"; areas are read in cm², volumes in litres.
 */
export function quantity(value: number, half: number | null, unit: string, units: Units): { value: string; half: string; unit: string } {
  const scale = scaleOf(unit, units);
  const shownHalf = half === null ? null : half / scale.per;
  const digits = digitsFor(shownHalf, scale.digits);
  return { value: fixed(value / scale.per, digits), half: shownHalf === null ? '' : fixed(shownHalf, digits), unit: scale.name };
}

function scaleOf(unit: string, units: Units): { per: number; name: string; digits: number } {
  if (unit === 'deg') return { per: 1, name: '°', digits: 1 };
  if (unit === 'mm2') return { per: 100, name: 'cm²', digits: 1 };
  if (unit === 'mm3') return { per: 1e6, name: 'L', digits: 3 };
  if (unit !== 'mm') return { per: 1, name: unit, digits: 2 };
  if (units === 'inch') return { per: kMmPerInch, name: 'in', digits: 2 };
  return units === 'cm' ? { per: 10, name: 'cm', digits: 2 } : { per: 1, name: 'mm', digits: 1 };
}

/** Decimals so that the half width has about two digits, at most `most`. */
function digitsFor(half: number | null, most: number): number {
  if (half === null || !(half > 0)) return most;
  return Math.min(Math.max(1 - Math.floor(Math.log10(half)), 0), most);
}
