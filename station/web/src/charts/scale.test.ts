import { describe, expect, it } from 'vitest';
import { median, moved, placed, quantile, robustRange, ticks, zoomed } from './scale';

describe('ticks', () => {
  it('are round numbers within the ends', () => {
    expect(ticks(0, 10, 5)).toEqual([0, 2, 4, 6, 8, 10]);
    expect(ticks(1483.2, 1771.9, 4)).toEqual([1500, 1600, 1700]);
    expect(ticks(-0.3, 0.3, 6)).toEqual([-0.3, -0.2, -0.1, 0, 0.1, 0.2, 0.3]);
  });
  it('are one for no width', () => expect(ticks(4, 4, 5)).toEqual([4]));
});

describe('the ends of a colour scale', () => {
  it('leave a wild value out', () => {
    const values = [...Array.from({ length: 99 }, (_, k) => k), 1e6];
    const range = robustRange(values, 0.96);
    expect(range.low).toBeCloseTo(1.98, 2);
    expect(range.high).toBeLessThan(100);
  });
  it('have zero in the middle where that is asked for', () => {
    expect(robustRange([-0.1, 0.4, 0.2, NaN], 1, { symmetric: true })).toEqual({ low: -0.4, high: 0.4 });
  });
  it('are never narrower than asked', () => {
    expect(robustRange([5, 5, 5], 1, { least: 2 })).toEqual({ low: 4, high: 6 });
    expect(robustRange([0, 0], 1, { symmetric: true, least: 0.2 })).toEqual({ low: -0.1, high: 0.1 });
    expect(robustRange([NaN], 1, { symmetric: true, least: 2 })).toEqual({ low: -1, high: 1 });
  });
});

describe('order statistics', () => {
  // numpy.quantile([1, 2, 4, 8], 0.4) = 2.4
  it('are linear between values', () => expect(quantile([1, 2, 4, 8], 0.4)).toBeCloseTo(2.4, 12));
  it('leave out what is not finite', () => {
    expect(median([3, NaN, 1, 2])).toBe(2);
    expect(median([NaN])).toBeNaN();
  });
});

it('a value is placed linearly', () => expect(placed(5, { low: 0, high: 10 }, { low: 100, high: 0 })).toBe(50));

describe('a window', () => {
  const whole = { low: 0, high: 100 };
  it('is zoomed about the place under the pointer', () => {
    expect(zoomed(whole, whole, 50, 0.5, 4)).toEqual({ low: 25, high: 75 });
    const near = zoomed({ low: 20, high: 60 }, whole, 30, 0.5, 4);
    expect((30 - near.low) / (near.high - near.low)).toBeCloseTo((30 - 20) / (60 - 20), 12);
  });
  it('stays within the whole and above its least width', () => {
    expect(zoomed(whole, whole, 10, 4, 4)).toEqual(whole);
    expect(zoomed({ low: 80, high: 100 }, whole, 100, 2, 4)).toEqual({ low: 60, high: 100 });
    expect(zoomed(whole, whole, 100, 0.001, 4)).toEqual({ low: 96, high: 100 });
  });
  it('is moved to the edge and no further', () => {
    expect(moved({ low: 10, high: 30 }, whole, -20)).toEqual({ low: 0, high: 20 });
    expect(moved({ low: 10, high: 30 }, whole, 500)).toEqual({ low: 80, high: 100 });
  });
});
