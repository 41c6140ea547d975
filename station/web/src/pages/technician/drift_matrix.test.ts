import { expect, it } from 'vitest';
import { driftMatrix } from './drift_matrix';

it('points of all sensors become scans in time order, each sensor in its column', () => {
  const { times, matrix } = driftMatrix([
    { index: 3, points: [[2000, 0.5, 0.1], [1000, 0.25, 0.1]] },
    { index: 7, points: [[1000, null, null], [3000, -0.125, 0.1]] },
  ]);
  expect(times).toEqual([1000, 2000, 3000]);
  expect([matrix.rows, matrix.columns]).toEqual([3, 180]);
  expect([0, 1, 2].map((row) => matrix.values[row * 180 + 3])).toEqual([0.25, 0.5, NaN]);
  expect([0, 1, 2].map((row) => matrix.values[row * 180 + 7])).toEqual([NaN, NaN, -0.125]);
});
