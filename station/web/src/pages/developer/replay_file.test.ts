import { expect, it } from 'vitest';
import { type OpenReplay, secondsOf, wholeTime } from './replay_file';

const replay = (events: number[], safety: number[]): OpenReplay => ({
  replay_id: '1', levels: 2, sweeps: 1, from_ns: 100e9, to_ns: 108e9, sensors: 180, radius_mm: 600,
  events: events.map((s) => ({ time_ns: s * 1e9, kind: 'event', text: '' })),
  safety: safety.map((s) => ({ time_ns: s * 1e9, line: 'door', level: true })),
});

it('times count from the first level', () => expect(secondsOf(replay([], []), 103.5e9)).toBe(3.5));

it('what is shown goes from the first event to the last, but not to homing long before', () => {
  expect(wholeTime(replay([20, 98.5, 109], [97]), 8)).toEqual({ low: -3, high: 9 });
  expect(wholeTime(replay([], []), 8)).toEqual({ low: 0, high: 8 });
  expect(wholeTime(replay([0], []), 0)).toEqual({ low: 0, high: 1 });
});
