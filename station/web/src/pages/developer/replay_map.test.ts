import { describe, expect, it } from 'vitest';
import { holdOf, rangesOf, readReplayMap, sensorsDown } from './replay_map';

/** Two levels of three sensors, written byte by byte as the document says. */
function bytes(): ArrayBuffer {
  const view = new DataView(new ArrayBuffer(8 + 4 * 6 + 4 * 2 + 8 * 2));
  view.setUint32(0, 2, true);
  view.setUint32(4, 3, true);
  [100, NaN, 300, 110, 210, 310].forEach((one, k) => view.setFloat32(8 + 4 * k, one, true));
  [1500, 1490].forEach((one, k) => view.setFloat32(32 + 4 * k, one, true));
  [0.25, 0.5].forEach((one, k) => view.setFloat64(40 + 8 * k, one, true));
  return view.buffer;
}

describe('the map of a recording', () => {
  it('is read as the station sends it', () => {
    const map = readReplayMap(bytes());
    expect([map.levels, map.sensors]).toEqual([2, 3]);
    expect([...map.zMm]).toEqual([1500, 1490]);
    expect([...map.timesS]).toEqual([0.25, 0.5]);
    expect(rangesOf(map, 0)).toEqual([100, null, 300]);
    expect(rangesOf(map, 1)).toEqual([110, 210, 310]);
  });
  it('is refused when it is cut short', () => {
    expect(() => readReplayMap(bytes().slice(0, 50))).toThrow('50 bytes instead of 56');
    expect(() => readReplayMap(new ArrayBuffer(3))).toThrow('cut short');
  });
  it('has time to the right', () => {
    const matrix = sensorsDown(readReplayMap(bytes()));
    expect([matrix.rows, matrix.columns]).toEqual([3, 2]);
    expect([...(matrix.values as Float32Array)]).toEqual([100, 110, NaN, 210, 300, 310]);
  });
});

it('a level is shown for one and a half usual steps', () => {
  expect(holdOf([0, 1, 2, 3, 30])).toBe(1.5);
  expect(holdOf([7])).toBe(1);
});
