import { describe, expect, it } from 'vitest';
import { angleOfSensor, boardBoundaries, contourRuns, frameFor, pointAt, polarOf, sensorAt } from './polar';

const frame = frameFor(400, 300, 600, 30);

describe('the ring seen from above', () => {
  it('fits into the shorter side', () => {
    expect(frame).toEqual({ centreX: 200, centreY: 150, scale: 0.2 });
  });
  it('has the front above and the right of the subject on the right', () => {
    const front = pointAt(frame, 90, 600);
    expect(front.x).toBeCloseTo(200, 9);
    expect(front.y).toBeCloseTo(30, 9);
    const right = pointAt(frame, 0, 300);
    expect(right.x).toBeCloseTo(260, 9);
    expect(right.y).toBeCloseTo(150, 9);
  });
  it('goes back from a place to theta and radius', () => {
    for (const thetaDeg of [0, 37, 90, 181, 359]) {
      const back = polarOf(frame, pointAt(frame, thetaDeg, 250));
      expect(back.thetaDeg).toBeCloseTo(thetaDeg, 9);
      expect(back.radius).toBeCloseTo(250, 9);
    }
  });
});

describe('picking a sensor', () => {
  it('takes the nearest beam', () => {
    expect(sensorAt(frame, pointAt(frame, 90.9, 400), 20)).toBe(45);
    expect(sensorAt(frame, pointAt(frame, 91.1, 400), 20)).toBe(46);
    expect(sensorAt(frame, pointAt(frame, 359.5, 400), 20)).toBe(0);
  });
  it('takes none where all beams meet', () => expect(sensorAt(frame, { x: 201, y: 150 }, 20)).toBeNull());
  it('knows sensors by their angles', () => expect([0, 45, 179].map(angleOfSensor)).toEqual([0, 90, 358]));
});

it('boards of fifteen sensors begin half a step before their first', () => {
  const boards = boardBoundaries();
  expect(boards).toHaveLength(12);
  expect(boards[0]).toEqual({ board: 0, first: 0, thetaDeg: 359 });
  expect(boards[3]).toEqual({ board: 3, first: 45, thetaDeg: 89 });
});

describe('the outline', () => {
  it('is closed where everything came back', () => {
    const runs = contourRuns([300, 301, 302, 301], 40);
    expect(runs).toEqual([[0, 1, 2, 3, 0]]);
  });
  it('breaks at a missing return, and goes on over sensor 0', () => {
    expect(contourRuns([300, 301, null, 302, 303], 40)).toEqual([[3, 4, 0, 1]]);
  });
  it('breaks at a jump to another surface', () => {
    expect(contourRuns([300, 300, 120, 121], 40)).toEqual([[0, 1], [2, 3]]);
  });
  it('is empty without returns', () => expect(contourRuns([null, null], 40)).toEqual([]));
});
