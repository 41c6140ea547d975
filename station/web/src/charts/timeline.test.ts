import { describe, expect, it } from 'vitest';
import { clustered, highStretches, levelAt, nearestLevel, Player } from './timeline';

const times = [0, 0.02, 0.04, 0.5, 0.52];

describe('time along a line', () => {
  it('finds the level that was there', () => {
    expect([-1, 0, 0.03, 0.04, 9].map((t) => levelAt(times, t))).toEqual([0, 0, 1, 2, 4]);
  });
  it('finds the nearest level', () => expect([0.009, 0.011, 0.3, 0.4].map((t) => nearestLevel(times, t))).toEqual([0, 1, 3, 3]));
});

describe('marks', () => {
  it('that would lie on each other become one', () => {
    const events = [0.1, 1, 1.01, 5].map((timeS) => ({ timeS }));
    const marks = clustered(events, { low: 0, high: 10 }, 1000, 8);
    expect(marks.map((mark) => mark.events.length)).toEqual([1, 2, 1]);
    expect(marks[2]!.x).toBe(500);
  });
  it('outside the window are left out', () => expect(clustered([{ timeS: 20 }], { low: 0, high: 10 }, 100, 5)).toEqual([]));
  it('of a line are its stretches, the last to the end', () => {
    const changes = [
      { timeS: 0, level: true },
      { timeS: 2, level: false },
      { timeS: 3, level: false },
      { timeS: 4, level: true },
    ];
    expect(highStretches(changes, 9)).toEqual([
      { low: 0, high: 2 },
      { low: 4, high: 9 },
    ]);
  });
});

describe('playing', () => {
  it('moves with the clock times the speed, and stops at the end', () => {
    const player = new Player({ low: 0, high: 10 });
    player.play(1000);
    expect(player.time(3000)).toBe(2);
    player.setSpeed(4, 3000);
    expect(player.time(4000)).toBe(6);
    expect(player.time(9000)).toBe(10);
    expect(player.playing(9000)).toBe(false);
  });
  it('stands while it is paused', () => {
    const player = new Player({ low: 0, high: 10 });
    player.play(0);
    player.pause(1500);
    expect(player.time(99000)).toBe(1.5);
    player.play(99000);
    expect(player.time(99500)).toBe(2);
  });
  it('goes on from where it was put', () => {
    const player = new Player({ low: 0, high: 10 });
    player.play(0);
    player.seek(7, 1000);
    expect(player.time(2000)).toBe(8);
    player.seek(70, 2000);
    expect(player.time(2000)).toBe(10);
  });
  it('begins anew at the end', () => {
    const player = new Player({ low: 0, high: 1 });
    player.seek(1, 0);
    player.play(0);
    expect(player.time(500)).toBe(0.5);
  });
});
