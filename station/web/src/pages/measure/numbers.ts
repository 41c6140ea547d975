// Numbers with their intervals, for people.
import type { Unit } from './api';

/** 1.96 sd on both sides hold the truth 19 times out of 20, if the errors are normal. */
export const sd95 = 1.96;

interface Shown {
  factor: number;
  unit: string;
  digits: number;
}

function shownAs(unit: Unit, size: number): Shown {
  switch (unit) {
    case 'mm': return { factor: 1, unit: 'mm', digits: 1 };
    case 'deg': return { factor: 1, unit: '°', digits: 1 };
    case 'mm2': return { factor: 0.01, unit: 'cm²', digits: 1 };
    case 'mm3': return size >= 1e6 ? { factor: 1e-6, unit: 'L', digits: 3 } : { factor: 1e-3, unit: 'cm³', digits: 1 };
  }
}

/** "571.2 mm"; areas in cm², volumes in cm³ or L. */
export function valueText(value: number, unit: Unit): string {
  const { factor, unit: name, digits } = shownAs(unit, Math.abs(value));
  return `${(value * factor).toFixed(digits)} ${name}`;
}

/** "571.2 ± 1.2 mm" (95 %); without a sigma the value alone. */
export function intervalText(value: number, sigma: number | null | undefined, unit: Unit): string {
  if (sigma === null || sigma === undefined) return valueText(value, unit);
  const { factor, unit: name, digits } = shownAs(unit, Math.abs(value));
  return `${(value * factor).toFixed(digits)} ± ${(sd95 * sigma * factor).toFixed(digits)} ${name}`;
}

/** "+2.7 mm", with the sign of a change. */
export function changeText(value: number, unit: Unit): string {
  return `${value < 0 ? '−' : '+'}${valueText(Math.abs(value), unit)}`;
}
